//! Materials: how surfaces scatter light.

/// Linear RGB: a reflectance, radiance or intensity for each channel.
pub type LinearRgb = [f64; 3];

/// A metal or alloy, defined by its complex index of refraction.
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

impl Metal {
    /// Real and imaginary part of the index of refraction, in linear RGB: Mitsuba's averages of
    /// measured spectra, and alloys.
    pub fn index_of_refraction(self) -> [LinearRgb; 2] {
        match self {
            Metal::Aluminium => [[1.6575, 0.880_41, 0.521_24], [9.223_81, 6.2695, 4.837]],
            Metal::Chromium => [[4.369_67, 2.916_51, 1.6549], [5.206_55, 4.231_31, 3.7547]],
            Metal::Copper => [[0.201, 0.923_75, 1.102_22], [3.913_26, 2.453_05, 2.142_09]],
            Metal::Silver => [[0.155_28, 0.116_73, 0.138_39], [4.828_35, 3.122_22, 2.1469]],
            Metal::Brass => [[0.444, 0.527, 1.094], [3.695, 2.765, 1.829]],
            Metal::Bronze => [[0.36, 0.72, 1.25], [3.6, 2.5, 2.1]],
        }
    }

    /// Reflectance at normal incidence.
    pub fn reflectance(self) -> LinearRgb {
        let [eta, k] = self.index_of_refraction();
        std::array::from_fn(|c| {
            let (n, k2) = (eta[c], k[c] * k[c]);
            ((n - 1.0).powi(2) + k2) / ((n + 1.0).powi(2) + k2)
        })
    }
}

/// Diffuse reflectance of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Reflectance {
    /// The same everywhere.
    Uniform(LinearRgb),
    /// From the texture of this name.
    Texture(&'static str),
}

/// A scattering model. All materials are two-sided. Roughness `alpha` is that of a GGX microfacet
/// distribution.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Lambertian.
    Diffuse(Reflectance),
    /// A diffuse base under a rough dielectric coat: paint, lacquer, glaze, polished stone,
    /// plastic.
    Coated {
        /// Reflectance of the base.
        base: Reflectance,
        /// Roughness of the coat.
        alpha: f64,
        /// Index of refraction of the coat.
        ior: f64,
    },
    /// A rough metal.
    Metal {
        /// Which metal.
        metal: Metal,
        /// Roughness.
        alpha: f64,
        /// Factor on the specular reflectance, for oxide, dirt or tinted lacquer.
        tint: LinearRgb,
    },
    /// Smooth clear glass around a volume.
    Glass {
        /// Index of refraction.
        ior: f64,
    },
    /// A linear mix of two materials with a weight from a texture.
    Mixed {
        /// Material at weight 0 (black).
        first: Box<Material>,
        /// Material at weight 1 (white).
        second: Box<Material>,
        /// Name of the texture of weights.
        weight: &'static str,
    },
}

/// Index of refraction of lacquer, glass and most plastics.
const LACQUER_IOR: f64 = 1.5;

/// Lambertian paint or cloth.
pub fn matte(color: LinearRgb) -> Material {
    Material::Diffuse(Reflectance::Uniform(color))
}

/// Lacquer, glaze or plastic of one color.
pub fn coated(color: LinearRgb, alpha: f64) -> Material {
    Material::Coated {
        base: Reflectance::Uniform(color),
        alpha,
        ior: LACQUER_IOR,
    }
}

/// A coat over a texture.
pub fn coated_texture(name: &'static str, alpha: f64) -> Material {
    Material::Coated {
        base: Reflectance::Texture(name),
        alpha,
        ior: LACQUER_IOR,
    }
}

/// A clean metal.
pub fn metal(metal: Metal, alpha: f64) -> Material {
    tinted_metal(metal, alpha, [1.0; 3])
}

/// A metal with the factor `tint` on its reflectance.
pub fn tinted_metal(metal: Metal, alpha: f64, tint: LinearRgb) -> Material {
    Material::Metal { metal, alpha, tint }
}

/// Clear glass.
pub fn glass() -> Material {
    Material::Glass { ior: LACQUER_IOR }
}
