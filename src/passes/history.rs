//! Two copies of a resource: one that this frame writes, and the one that the last frame wrote.

/// This frame's and the last frame's images, which swap places in [`History::advance`].
pub struct History<T> {
    copies: [T; 2],
    /// The copy that the last frame wrote; none without a history.
    last: Option<usize>,
}

impl<T> History<T> {
    /// Makes both copies; neither holds anything yet.
    ///
    /// # Errors
    /// The copies by `make`, which is given the number of the copy.
    pub fn new<E>(mut make: impl FnMut(usize) -> Result<T, E>) -> Result<Self, E> {
        Ok(Self { copies: [make(0)?, make(1)?], last: None })
    }

    /// Whether the last frame wrote anything.
    pub fn is_valid(&self) -> bool {
        self.last.is_some()
    }

    /// The copy that the last frame wrote; undefined where the history is not valid.
    pub fn last(&self) -> &T {
        &self.copies[self.last.unwrap_or_default()]
    }

    /// The copy that this frame writes.
    pub fn next(&self) -> &T {
        &self.copies[1 - self.last.unwrap_or_default()]
    }

    /// Makes what this frame wrote the last frame's.
    pub fn advance(&mut self) {
        self.last = Some(1 - self.last.unwrap_or_default());
    }

    /// Forgets what the last frame wrote.
    pub fn forget(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_swap_and_are_forgotten() {
        let mut history = History::new(Ok::<usize, ()>).unwrap();
        assert!(!history.is_valid());
        let first = *history.next();
        history.advance();
        assert_eq!((history.is_valid(), *history.last()), (true, first));
        assert_ne!(history.next(), history.last());
        history.advance();
        assert_ne!(*history.last(), first);
        history.forget();
        assert!(!history.is_valid());
    }
}
