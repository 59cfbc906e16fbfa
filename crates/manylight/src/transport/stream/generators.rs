//! Random numbers in lanes: one generator per walk.

use crate::bsdf::Numbers;
use crate::lanes::{Float, Pair, Width};
use crate::sampling::{Pcg, Sampler};

/// A [`Sampler`] per lane. Each lane has the numbers that its sampler alone would have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Generators<S: Width> {
    s: S,
    states: S::Each<u64>,
    increments: S::Each<u64>,
}

impl<S: Width> Generators<S> {
    /// The sampler `sampler(i)` in each lane `i`.
    #[inline(always)]
    pub(crate) fn from_fn<'a>(s: S, sampler: impl Fn(usize) -> &'a Sampler) -> Self {
        Generators {
            s,
            states: s.each(|i| sampler(i).parts().0),
            increments: s.each(|i| sampler(i).parts().1),
        }
    }

    /// The sampler of lane `i`.
    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Sampler {
        Sampler::from_parts(self.states.as_ref()[i], self.increments.as_ref()[i])
    }

    /// Calls `draw` with the sampler of lane `i`.
    #[inline(always)]
    pub(crate) fn draw<T>(&mut self, i: usize, draw: impl FnOnce(&mut Sampler) -> T) -> T {
        let mut sampler = self.get(i);
        let drawn = draw(&mut sampler);
        (self.states.as_mut()[i], self.increments.as_mut()[i]) = sampler.parts();
        drawn
    }

    /// The next number of each lane.
    #[inline(always)]
    pub(crate) fn next(&mut self) -> Float<S> {
        let (states, increments) = (self.states.as_mut(), self.increments.as_ref());
        let mut numbers = self.s.each(|_| 0.0);
        for (i, number) in numbers.as_mut().iter_mut().enumerate() {
            *number = Pcg::number(states[i]);
            states[i] = Pcg::advance(states[i], increments[i]);
        }
        Float::load(self.s, &numbers)
    }

    /// The next two numbers of each lane.
    #[inline(always)]
    pub(crate) fn next_pair(&mut self) -> Pair<S> {
        let x = self.next();
        Pair::new(x, self.next())
    }

    /// The numbers of a sample of a scattering function.
    #[inline(always)]
    pub(crate) fn next_bsdf(&mut self) -> Numbers<S> {
        let lobe = self.next();
        Numbers {
            lobe,
            direction: self.next_pair(),
        }
    }
}
