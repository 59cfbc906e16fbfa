//! Boxes in the form in which trees are built from them.

use crate::math::{Aabb, Vec4};
use glam::Vec4Swizzles;

/// The corners of a triangle, each before one number that is not read.
pub(in crate::geometry) type CornerRows = [[f32; 4]; 3];

/// The bounding box of an item.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct ItemBox {
    /// Lower corner, and the bits of the item's index.
    lower: [f32; 4],
    /// Upper corner; the last component is unused.
    upper: [f32; 4],
}

impl ItemBox {
    pub(super) fn new(bounds: Aabb, item: u32) -> Self {
        ItemBox {
            lower: bounds.min.extend(f32::from_bits(item)).to_array(),
            upper: bounds.max.extend(0.0).to_array(),
        }
    }

    /// The box of a triangle, from its corners.
    #[inline(always)]
    pub(super) fn around(corners: &CornerRows, item: u32) -> Self {
        let [a, b, c] = *corners;
        let (a, b, c) = (
            Vec4::from_array(a),
            Vec4::from_array(b),
            Vec4::from_array(c),
        );
        let mut lower = a.min(b).min(c).to_array();
        lower[3] = f32::from_bits(item);
        let upper = a.max(b).max(c).to_array();
        ItemBox { lower, upper }
    }

    /// Index of the item.
    #[inline(always)]
    pub(super) fn item(&self) -> u32 {
        self.lower[3].to_bits()
    }

    /// Twice the center.
    #[inline(always)]
    pub(super) fn twice_center(&self) -> Vec4 {
        Vec4::from_array(self.lower) + Vec4::from_array(self.upper)
    }

    /// A component of [`ItemBox::twice_center`].
    #[inline(always)]
    pub(super) fn twice_center_along(&self, axis: usize) -> f32 {
        self.lower[axis % 4] + self.upper[axis % 4]
    }
}

/// A box in two vectors; their last components have no meaning.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) lower: Vec4,
    pub(super) upper: Vec4,
}

impl Bounds {
    /// The empty box.
    pub(super) const EMPTY: Bounds = Bounds {
        lower: Vec4::INFINITY,
        upper: Vec4::NEG_INFINITY,
    };

    /// The smallest box around `items`.
    pub(super) fn of(items: &[ItemBox]) -> Self {
        items.iter().fold(Bounds::EMPTY, Bounds::with)
    }

    /// The smallest box around `self` and `item`.
    #[inline(always)]
    pub(super) fn with(self, item: &ItemBox) -> Self {
        Bounds {
            lower: self.lower.min(Vec4::from_array(item.lower)),
            upper: self.upper.max(Vec4::from_array(item.upper)),
        }
    }

    /// The smallest box around `self` and `p`.
    #[inline(always)]
    pub(super) fn include(self, p: Vec4) -> Self {
        Bounds {
            lower: self.lower.min(p),
            upper: self.upper.max(p),
        }
    }

    /// The smallest box around both boxes.
    #[inline(always)]
    pub(super) fn union(self, o: Bounds) -> Self {
        Bounds {
            lower: self.lower.min(o.lower),
            upper: self.upper.max(o.upper),
        }
    }

    /// Half the surface area; infinite for the empty box.
    #[inline(always)]
    pub(super) fn half_area(self) -> f32 {
        let d = self.upper - self.lower;
        let products = (d * d.yzxw()).to_array();
        products[0] + products[1] + products[2]
    }
}

impl From<Bounds> for Aabb {
    #[inline(always)]
    fn from(bounds: Bounds) -> Self {
        Aabb {
            min: bounds.lower.truncate(),
            max: bounds.upper.truncate(),
        }
    }
}
