//! JSON pointers (RFC 6901): the location of a value in a case.

use std::fmt;

/// A JSON pointer, e.g. `/time/step`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pointer(String);

impl Pointer {
    /// The whole document.
    pub fn root() -> Self {
        Self::default()
    }

    /// The value of `key` in the object this points to.
    #[must_use]
    pub fn key(&self, key: &str) -> Self {
        Self(format!("{}/{}", self.0, key.replace('~', "~0").replace('/', "~1")))
    }

    /// Entry `index`, counted from 0, of the list this points to.
    #[must_use]
    pub fn index(&self, index: usize) -> Self {
        Self(format!("{}/{index}", self.0))
    }

    /// A pointer below this one, as another reader reports it (`/annulus/nodes`).
    #[must_use]
    pub fn below(&self, rest: &str) -> Self {
        Self(format!("{}{rest}", self.0))
    }

    /// The last step of the pointer, unescaped; empty at the root.
    pub fn last(&self) -> String {
        let tail = self.0.rsplit('/').next().unwrap_or_default();
        tail.replace("~1", "/").replace("~0", "~")
    }

    /// As RFC 6901 writes it.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Pointer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The root pointer is the empty string, which would look like a mistake in a message.
        f.write_str(if self.0.is_empty() { "/" } else { &self.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::Pointer;

    /// Keys with the two special characters survive, so that `serde_json::Value::pointer` finds them again.
    #[test]
    fn escapes_as_rfc_6901_says() {
        let value = serde_json::json!({"a/b": {"c~d": [1, 2]}});
        let at = Pointer::root().key("a/b").key("c~d").index(1);
        assert_eq!(at.as_str(), "/a~1b/c~0d/1");
        assert_eq!(value.pointer(at.as_str()), Some(&serde_json::json!(2)));
        assert_eq!(Pointer::root().key("a/b").last(), "a/b");
    }
}
