//! How often the picture is shown.

use std::time::{Duration, Instant};

/// Shortest time between two pictures. It decides for pictures that take less than 20 ms, which
/// [`LARGEST_SHARE`] would allow more often: 22 channels of up to 92 000 pixels, at 0.05 s for
/// 640x360 (docs/preview.md). These are 8 MB of floats a second for tev; half the time is twice the
/// data, and twice the time lets the eye wait at passes of a fraction of a second.
const MIN_INTERVAL: Duration = Duration::from_secs(1);

/// Largest part of the time of a render that is spent on pictures after the first one. A picture of
/// 22 channels takes 0.05 s at 640x360 and 0.5 s at 1920x1080 (docs/preview.md), and is shown every
/// 2.5 and 25 s. Half the part doubles these times; twice the part slows the render by another 2 %.
const LARGEST_SHARE: f64 = 0.02;

/// Decides when a picture is due, by the time of the last one and what it cost.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    last: Option<Instant>,
    cost: Duration,
}

impl Pace {
    /// Whether a picture is due. The first one always is.
    pub(crate) fn is_due(&self, now: Instant) -> bool {
        self.last
            .is_none_or(|last| now.saturating_duration_since(last) >= self.interval())
    }

    /// Notes that a picture was made from `start` to `end`.
    pub(crate) fn note(&mut self, start: Instant, end: Instant) {
        self.last = Some(end);
        self.cost = end.saturating_duration_since(start);
    }

    fn interval(&self) -> Duration {
        MIN_INTERVAL.max(self.cost.div_f64(LARGEST_SHARE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_costly_picture_is_rare() {
        let ms = Duration::from_millis;
        let start = Instant::now();
        let mut pace = Pace::default();
        assert!(pace.is_due(start));
        pace.note(start, start + ms(5));
        assert!(!pace.is_due(start + ms(900)));
        assert!(pace.is_due(start + ms(1005)));
        pace.note(start, start + ms(100));
        assert!(!pace.is_due(start + ms(5000)));
        assert!(pace.is_due(start + ms(5101)));
    }
}
