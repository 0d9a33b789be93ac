//! Changes to one value of a case that is JSON: bytes changed at random are seldom a case that runs.

use canopy_fem::integrate::registry::methods;
use libfuzzer_sys::fuzzer_mutate;
use serde_json::{Value, json};

/// Numbers from all ends of a double, and those where something begins or ends.
const NUMBERS: [f64; 40] = [
    0.0, -0.0, 1.0, -1.0, 0.5, 2.0, 3.0, 1e-3, 0.1, 10.0, 50.0, 340.0, 1e3, 1e4, 1e6, 1e9, 1e12, 1e15, 1e-6, 1e-9, 1e-12, 1e-15,
    1e100, 1e150, 1e200, 1e300, 1.7e308, 1e-100, 1e-150, 1e-200, 1e-300, 2.3e-308, 1e-310, 5e-324, -1e-300, -1e9, -1e200, 0.9,
    0.999_999_999, 1.000_000_001,
];

/// Words of cases beside the names of methods.
const WORDS: [&str; 25] = [
    "all", "boundary", "interior", "seams", "lines", "outer", "inner", "xyz", "z", "xy", "tension-only", "step",
    "corrected", "paper", "follower", "dead", "full", "auto", "lu", "cholesky", "cg", "crossed", "regular",
    "velocity", "tension",
];

/// A generator of SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }
}

/// Changes a value of the case in two of three calls, if there is a case; else bytes.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let mut random = Random(u64::from(seed));
    if random.below(3) > 0
        && let Some(text) = data.get(..size).and_then(|bytes| changed(bytes, &mut random))
        && text.len() <= max_size
        && let Some(room) = data.get_mut(..text.len())
    {
        room.copy_from_slice(&text);
        return text.len();
    }
    fuzzer_mutate(data, size, max_size)
}

fn changed(bytes: &[u8], random: &mut Random) -> Option<Vec<u8>> {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    let mut case: Value = serde_json::from_slice(bytes.get(..end)?).ok()?;
    for _ in 0..=random.below(3) {
        let count = leaves(&case);
        change(&mut case, &mut random.below(count), random);
    }
    let mut text = case.to_string().into_bytes();
    text.extend_from_slice(bytes.get(end..)?);
    Some(text)
}

fn leaves(value: &Value) -> usize {
    match value {
        Value::Array(list) => 1 + list.iter().map(leaves).sum::<usize>(),
        Value::Object(map) => 1 + map.values().map(leaves).sum::<usize>(),
        _ => 1,
    }
}

/// Changes the value number `skip` of a tree; whether it was in there.
fn change(value: &mut Value, skip: &mut usize, random: &mut Random) -> bool {
    if *skip == 0 {
        spoil(value, random);
        return true;
    }
    *skip -= 1;
    match value {
        Value::Array(list) => list.iter_mut().any(|v| change(v, skip, random)),
        Value::Object(map) => map.values_mut().any(|v| change(v, skip, random)),
        _ => false,
    }
}

fn spoil(value: &mut Value, random: &mut Random) {
    match value {
        Value::Number(number) => {
            let old = number.as_f64().unwrap_or(0.0);
            let other = NUMBERS[random.below(NUMBERS.len())];
            *value = match random.below(6) {
                0 => json!(random.below(12)),
                1 => json!(old * other),
                2 => json!(-old),
                3 => json!(old * (1.0 + 1e-3 * random.below(1000) as f64)),
                _ => json!(other),
            };
        }
        Value::String(word) => {
            let words: Vec<&str> = WORDS.into_iter().chain(methods().iter().map(|method| method.name)).collect();
            *word = words[random.below(words.len())].to_owned();
        }
        Value::Array(list) if !list.is_empty() => {
            let at = random.below(list.len());
            match random.below(3) {
                0 => drop(list.remove(at)),
                1 => list.push(list[at].clone()),
                _ => {
                    let with = random.below(list.len());
                    list.swap(at, with);
                }
            }
        }
        Value::Object(map) if random.below(4) == 0 => {
            if let Some(key) = map.keys().nth(random.below(map.len())).cloned() {
                map.remove(&key);
            }
        }
        Value::Bool(flag) => *flag = !*flag,
        _ => {}
    }
}
