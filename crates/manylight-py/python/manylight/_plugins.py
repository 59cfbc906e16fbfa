"""Tags of the plugins in Mitsuba's XML, by name."""

from ._native import plugins

# Plugins without effect on the converged image, and those that the loader answers by name.
_OTHERS = {
    "bsdf": "circular hair measured measured_polarized polarizer pplastic principledhair retarder roughbsdf roughcoating sdf".split(),
    "emitter": "directionalarea timedsunsky".split(),
    "film": "hdrfilm ldrfilm specfilm".split(),
    "integrator": "depth prb prb_basic prbvolpath stokes volprim_rf_basic".split(),
    "medium": "heterogeneous homogeneous".split(),
    "phase": "blendphase hg isotropic rayleigh sggx tabphase".split(),
    "sampler": "independent ldsampler multijitter orthogonal stratified".split(),
    "sensor": "batch distant irradiancemeter radiancemeter".split(),
    "shape": "blender ellipsoids ellipsoidsmesh sdfgrid".split(),
    "spectrum": "d65 irregular regular uniform".split(),
    "texture": ["volume"],
    "volume": "constvolume gridvolume".split(),
}

_TAG_OF_FAMILY = {
    "bsdfs": "bsdf",
    "emitters": "emitter",
    "filters": "rfilter",
    "integrators": "integrator",
    "sensors": "sensor",
    "shapes": "shape",
    "textures": "texture",
}

TAGS: dict[str, str] = {name: tag for tag, names in _OTHERS.items() for name in names}
TAGS.update((name, _TAG_OF_FAMILY[family]) for family, names in plugins().items() for name in names)
