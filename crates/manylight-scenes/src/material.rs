//! What surfaces are made of.

/// A linear RGB color, or reflectance for each of the three.
pub type Rgb = [f64; 3];

/// A pure metal or alloy, known by its complex index of refraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metal {
    /// Al
    Aluminium,
    /// Cu with 30 % Zn
    Brass,
    /// Cr
    Chromium,
    /// Cu
    Copper,
    /// Ag
    Silver,
    /// Cu with 10 % Sn, darker and redder than brass
    Bronze,
}

/// A color that may vary over the surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Color {
    /// The same everywhere.
    Flat(Rgb),
    /// From a picture of the scene, by its name.
    Picture(&'static str),
}

/// How a surface scatters light. Roughness is the `alpha` of a GGX microfacet distribution; every material is the same on
/// both of its sides.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Lambertian.
    Diffuse(Color),
    /// A diffuse base under a rough clear coat: paint, lacquer, glaze, polished stone, plastic.
    Coated {
        /// Color of the base.
        base: Color,
        /// Roughness of the coat.
        alpha: f64,
        /// Index of refraction of the coat.
        ior: f64,
    },
    /// A rough metal.
    Metal {
        /// Which one.
        metal: Metal,
        /// Roughness.
        alpha: f64,
        /// Factor on what it reflects: oxide, dirt, tinted lacquer.
        tint: Rgb,
    },
    /// A body of clear smooth glass.
    Glass {
        /// Index of refraction.
        ior: f64,
    },
    /// Two materials, mixed by a picture's brightness: black is the first, white the second.
    Mixed {
        /// Where the picture is black.
        first: Box<Material>,
        /// Where the picture is white.
        second: Box<Material>,
        /// Name of the picture.
        weight: &'static str,
    },
}

/// Index of refraction of lacquers and most plastics.
const LACQUER_IOR: f64 = 1.5;

/// Matte paint or cloth.
pub fn matte(color: Rgb) -> Material {
    Material::Diffuse(Color::Flat(color))
}

/// Lacquer, glaze or plastic of one color.
pub fn coated(color: Rgb, alpha: f64) -> Material {
    Material::Coated {
        base: Color::Flat(color),
        alpha,
        ior: LACQUER_IOR,
    }
}

/// A coat over a picture.
pub fn coated_picture(name: &'static str, alpha: f64) -> Material {
    Material::Coated {
        base: Color::Picture(name),
        alpha,
        ior: LACQUER_IOR,
    }
}

/// A clean metal.
pub fn metal(metal: Metal, alpha: f64) -> Material {
    tinted_metal(metal, alpha, [1.0; 3])
}

/// A metal that reflects only a share of what a clean one does.
pub fn tinted_metal(metal: Metal, alpha: f64, tint: Rgb) -> Material {
    Material::Metal { metal, alpha, tint }
}

/// Clear glass.
pub fn glass() -> Material {
    Material::Glass { ior: LACQUER_IOR }
}
