//! Values that change in a run, such as a factor that a program sets. Terms, tables and the scene share each of them by
//! an `Arc`. Another run has a copy of each, which its terms, tables and scene share in the same way.

use std::any::Any;
use std::collections::HashMap;
use std::sync::Arc;

/// The copies for another run, by where what they are copies of is.
#[derive(Default)]
pub struct Copies(HashMap<*const (), Arc<dyn Any + Send + Sync>>);

impl Copies {
    /// The copy of a value, made when it is first asked for.
    pub fn of<T: Any + Send + Sync + Clone>(&mut self, value: &Arc<T>) -> Arc<T> {
        let made = self.0.entry(Arc::as_ptr(value).cast()).or_insert_with(|| Arc::new(T::clone(value)));
        // No two values are at one place.
        made.clone().downcast().unwrap_or_else(|_| Arc::new(T::clone(value)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::law::series::Scale;

    #[test]
    fn what_was_shared_is_shared_again() {
        let [one, other] = [Arc::new(Scale::default()), Arc::new(Scale::default())];
        one.set(2.0);
        let mut copies = Copies::default();
        let made = [copies.of(&one), copies.of(&other), copies.of(&one)];
        made[2].set(3.0);
        assert_eq!(made.map(|scale| scale.get()), [3.0, 1.0, 3.0]);
        assert_eq!([one.get(), other.get()], [2.0, 1.0]);
    }
}
