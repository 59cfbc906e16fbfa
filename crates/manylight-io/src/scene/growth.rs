//! A bound for what is made from the data of a file: any number of its parts may use the same data.

use super::sink::{FileSpan, Sink};

/// Most bytes that may be made: the larger of both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// As a multiple of the given ones.
    pub(super) ratio: usize,
    /// For small files.
    pub(super) always_allowed: usize,
}

impl Exceeded {
    /// Adds an error at `span`, the first time.
    pub(super) fn report(self, sink: &Sink, code: &'static str, span: FileSpan) {
        if let Some(message) = self.message {
            sink.error_at(code, span, message);
        }
    }
}

/// What is made so far, and the bound.
#[derive(Debug)]
pub(super) struct Growth {
    /// Bytes of data in the files.
    given: usize,
    /// Bytes made from them.
    made: usize,
    bound: Bound,
    exceeded: bool,
}

/// The bound is exceeded. The message is given the first time only.
pub(super) struct Exceeded {
    pub(super) message: Option<String>,
}

impl Growth {
    /// For `given` bytes of data.
    pub(super) fn new(given: usize, bound: Bound) -> Self {
        Growth {
            given,
            made: 0,
            bound,
            exceeded: false,
        }
    }

    /// Bytes of data so far.
    pub(super) fn given(&self) -> usize {
        self.given
    }

    /// Adds data of one more file.
    pub(super) fn give(&mut self, bytes: usize) {
        self.given += bytes;
    }

    /// Adds bytes that are made. `message` gets the most bytes that may be made, and the bytes of data.
    ///
    /// # Errors
    /// The bound is exceeded, now or before.
    pub(super) fn make(
        &mut self,
        bytes: usize,
        message: impl FnOnce(usize, usize) -> String,
    ) -> Result<(), Exceeded> {
        self.made = self.made.saturating_add(bytes);
        let most = self.given.saturating_mul(self.bound.ratio);
        let most = most.max(self.bound.always_allowed);
        if !self.exceeded && self.made <= most {
            return Ok(());
        }
        let message = (!self.exceeded).then(|| message(most, self.given));
        self.exceeded = true;
        Err(Exceeded { message })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_made_is_bounded_by_the_data() {
        let mut growth = Growth::new(
            1 << 20,
            Bound {
                ratio: 100,
                always_allowed: 64 << 20,
            },
        );
        let mut make = |bytes| growth.make(bytes, |most, given| format!("{most} from {given}"));
        for _ in 0..8 {
            assert!(make(12 << 20).is_ok());
        }
        let exceeded = make(12 << 20).unwrap_err();
        assert_eq!(exceeded.message.unwrap(), "104857600 from 1048576");
        assert!(make(0).unwrap_err().message.is_none());
    }
}
