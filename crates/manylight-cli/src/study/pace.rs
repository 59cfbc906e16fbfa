//! How long the rest will take.

use super::runs::Run;

/// Times of the runs that are known, and an estimate of others by them.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    taken: Vec<Taken>,
}

#[derive(Debug)]
struct Taken {
    task: String,
    method: String,
    seconds: f64,
}

impl Pace {
    /// A run took so long.
    pub(crate) fn note(&mut self, run: &Run, seconds: f64) {
        self.note_named(&run.task_name, &run.method.label, seconds);
    }

    fn note_named(&mut self, task: &str, method: &str, seconds: f64) {
        self.taken.push(Taken {
            task: task.into(),
            method: method.into(),
            seconds,
        });
    }

    /// Seconds that these runs will take; `None` while nothing is known about one of them.
    pub(crate) fn remaining(&self, runs: &[&Run]) -> Option<f64> {
        let expected = |run: &&Run| {
            let time = run.time().map(|time| time.as_secs_f64());
            self.expected(&run.task_name, &run.method.label, time)
        };
        runs.iter().map(expected).sum()
    }

    /// By the same method under the same task, by the time that is asked for, by the task, by all: what is known first.
    fn expected(&self, task: &str, method: &str, time: Option<f64>) -> Option<f64> {
        self.mean(|t| t.task == task && t.method == method)
            .or(time)
            .or_else(|| self.mean(|t| t.task == task))
            .or_else(|| self.mean(|_| true))
    }

    fn mean(&self, fits: impl Fn(&Taken) -> bool) -> Option<f64> {
        let seconds: Vec<f64> = (self.taken.iter())
            .filter(|t| fits(t))
            .map(|t| t.seconds)
            .collect();
        (!seconds.is_empty()).then(|| seconds.iter().sum::<f64>() / seconds.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_alike_runs_tell() {
        let mut pace = Pace::default();
        assert_eq!(pace.expected("t", "a", None), None);
        assert_eq!(pace.expected("t", "a", Some(8.0)), Some(8.0));
        pace.note_named("t", "a", 10.0);
        pace.note_named("t", "a", 20.0);
        pace.note_named("t", "b", 30.0);
        pace.note_named("u", "b", 60.0);
        assert_eq!(pace.expected("t", "a", Some(8.0)), Some(15.0));
        assert_eq!(pace.expected("t", "c", None), Some(20.0));
        assert_eq!(pace.expected("v", "a", None), Some(30.0));
    }
}
