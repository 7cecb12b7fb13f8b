//! Values that one thread uses.

use std::thread::{self, ThreadId};

/// A value that only the thread that made it can use.
///
/// Operators are shared between the threads of a process, PETSc is called by one of them.
pub struct OneThread<T> {
    thread: ThreadId,
    value: T,
}

// SAFETY: other threads cannot reach the value: `get` returns it on the thread that made it only.
// It is dropped there too, because the type is not `Send` unless `T` is.
unsafe impl<T> Sync for OneThread<T> {}

impl<T> OneThread<T> {
    pub fn new(value: T) -> Self {
        Self {
            thread: thread::current().id(),
            value,
        }
    }

    /// The value; none on other threads.
    pub fn get(&self) -> Option<&T> {
        (thread::current().id() == self.thread).then_some(&self.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_thread_gets_nothing() {
        let value = OneThread::new(std::cell::Cell::new(1));
        assert_eq!(value.get().map(std::cell::Cell::get), Some(1));
        thread::scope(|scope| {
            scope.spawn(|| assert!(value.get().is_none()));
        });
    }
}
