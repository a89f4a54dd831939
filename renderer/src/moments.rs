//! Motion blur: which moment of the shutter's interval each sample sees.
//!
//! A pixel's samples are cut into **blocks**, one for each step of the interval, in an order that spreads any number of them
//! over all of it (van der Corput's). Where there are more moments than samples, pixels are in **groups**: within its step
//! each group sees another moment, so that pixels beside one another do not repeat what moves at the same places. All of it
//! follows from the pixel and the sample alone.

use glam::UVec2;

/// How a picture's samples are shared out.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    /// Samples of a block.
    length: u32,
    /// The step of the interval that each block sees.
    steps: Vec<u32>,
    /// Moments of a step.
    groups: u32,
}

impl Blocks {
    /// `moments` of the interval, for up to `samples` a pixel; `None` if there is at most one.
    pub fn new(moments: usize, samples: u32) -> Option<Blocks> {
        let (moments, samples) = (u32::try_from(moments).ok()?, samples.max(1));
        if moments < 2 {
            return None;
        }
        let groups = if moments > samples { moments.div_ceil(samples) } else { 1 };
        let count = moments / groups;
        let bits = count.next_power_of_two().trailing_zeros();
        let mut steps: Vec<u32> = (0..count).collect();
        steps.sort_by_key(|step| step.reverse_bits() >> (32 - bits).min(31));
        Some(Blocks { length: samples.div_ceil(count), steps, groups })
    }

    /// Where the block that `first` is in ends.
    pub fn end(&self, first: u32) -> u32 {
        (first / self.length + 1).saturating_mul(self.length)
    }

    /// The least number of samples, from `wanted` on, of which each part of the interval sees as many: 1, 2, 4, 8.. blocks.
    pub fn even(&self, wanted: u32) -> u32 {
        wanted.div_ceil(self.length).checked_next_power_of_two().unwrap_or(u32::MAX).saturating_mul(self.length)
    }

    /// Groups of pixels.
    pub fn groups(&self) -> u32 {
        self.groups
    }

    /// The moment that sample `first` and the others of its block see, in a group of pixels.
    pub fn moment(&self, first: u32, group: u32) -> usize {
        let block = (first / self.length) as usize % self.steps.len();
        (self.steps[block] * self.groups + group) as usize
    }

    /// The group of a pixel during the block that `first` is in.
    pub fn group(&self, pixel: UVec2, first: u32) -> u32 {
        let mut h = pixel.x.wrapping_mul(0x9e37_79b1) ^ pixel.y.wrapping_mul(0x85eb_ca77);
        h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
        h ^= h >> 13;
        (h.wrapping_add(first / self.length)) % self.groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_moment_is_seen_as_often() {
        for (moments, samples, groups) in [(2, 64, 1), (16, 16, 1), (10, 100, 1), (25, 100, 1), (64, 16, 4), (12, 3, 4)]
        {
            let blocks = Blocks::new(moments, samples).unwrap();
            assert_eq!(blocks.groups(), groups);
            let mut seen = vec![0; moments];
            for sample in 0..samples {
                for group in 0..groups {
                    seen[blocks.moment(sample, group)] += 1;
                }
            }
            assert!(seen.iter().all(|times| *times == seen[0]), "{moments} of {samples}: {seen:?}");
        }
        assert_eq!(Blocks::new(0, 16), None);
        assert_eq!(Blocks::new(1, 16), None);
    }

    #[test]
    fn the_first_blocks_cover_the_interval() {
        let blocks = Blocks::new(16, 64).unwrap();
        assert_eq!([0, 4, 8, 12].map(|first| blocks.moment(first, 0)), [0, 8, 4, 12]);
        assert_eq!((blocks.end(0), blocks.end(3), blocks.end(4)), (4, 4, 8));
        assert_eq!([1, 5, 9, 32, 33, 64].map(|wanted| blocks.even(wanted)), [4, 8, 16, 32, 64, 64]);
    }

    #[test]
    fn groups_are_as_large() {
        let blocks = Blocks::new(64, 16).unwrap();
        let mut count = [0; 4];
        for i in 0..4096 {
            count[blocks.group(UVec2::new(i % 64, i / 64), 0) as usize] += 1;
        }
        assert!(count.iter().all(|count| (900..1150).contains(count)), "{count:?}");
    }
}
