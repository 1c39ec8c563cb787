//! How deep the tests go: `./test` takes minutes, `./test --all` looks into more of everything.

/// Whether all is tested.
pub fn all() -> bool {
    std::env::var("GLOWWORM_ALL").is_ok_and(|value| value == "1")
}

/// The first of two numbers in a quick run, the second where [`all`] is tested.
pub fn quick_or_all<T>(quick: T, all_of_them: T) -> T {
    if all() { all_of_them } else { quick }
}
