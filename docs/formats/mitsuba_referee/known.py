"""Differences with named causes: patterns of case names, the kind of the cause, and the cause.

Kinds: `ours` and `theirs` (the values of that program are wrong), `lenient` (we read what Mitsuba refuses), `approximated` (a limit
that docs/formats/mitsuba.md states, with a warning), `unsupported` (with one warning), `unexplained`.
"""

KNOWN: list[tuple[tuple[str, ...], str, str]] = [
    (
        ("conductor material *_palik", "conductor material ??-e", "conductor material TiO2-e"),
        "ours",
        "34 of Mitsuba's 72 names of metals are unknown",
    ),
    (("conductor material AlSb",), "ours", "0/0 at normal incidence where eta and k are 0: black; Mitsuba's red is not a number"),
    (("* uniform", "* texture tag"), "ours", "the plugin `uniform` on an emitter is taken as the equal-energy spectrum"),
    (("slanted * flags",), "ours", "`flip_invalid_normals` and `use_shadowing_function` are ignored, silently"),
    (("spot to_world scale(x=*",), "ours", "an uneven scale in `to_world` does not deform the cone"),
    (("directional to_world scale*", "projector * to_world scale*"), "ours", "a scale in `to_world` does not change the brightness"),
    (
        ("envmap scaled transform", "envmap stretched transform"),
        "ours",
        "a scale in `to_world` is ignored, silently; Mitsuba's map is deformed",
    ),
    (("envmap filename sky2x2.exr",), "ours", "Mitsuba enlarges maps to at least 2 x 3 texels"),
    (("path max_depth 0",), "ours", "emission is shown at depth 0"),
    (("path hide_emitters behind a mask",), "unexplained", "the emitters seen through a mask"),
    (
        ("nested blend of glass", "nested blend of blends", "texture as coloured weight", "texture as gray weight, sRGB"),
        "unexplained",
        "a `blendbsdf` with a specular part",
    ),
    (("slanted normalmap of a bumpmap",), "unexplained", "bumps within a normal map"),
    (("lamp cube textured",), "unexplained", "a textured emission on a cube"),
    (("version 0.6 rotation",), "theirs", "Mitsuba 3 does not normalize the axis in files of 0.x, which 0.6 did"),
    (("mesh_attribute vertex bytes",), "theirs", "colors of 8 bits are taken as 0 to 255; we read fractions and warn"),
    (("bsdf polarizer", "bsdf circular", "bsdf retarder", "bsdf pplastic", "bsdf hair"), "unsupported", "replaced"),
    (("volume texture *",), "unsupported", "a constant"),
    (("sunsky complex_sun True", "timed_sunsky", "directionalarea"), "unsupported", "a uniform sun, or nothing"),
    (
        ("lamp * stretched", "shape * stretched"),
        "approximated",
        "spheres and cylinders under an uneven scale, which Mitsuba does not define",
    ),
    (("transform axis that is no unit vector",), "approximated", "the picture agrees; the warning is meant"),
    (("* blackbody*", "* regular", "* irregular"), "lenient", "not implemented in Mitsuba's RGB variants here"),
    (
        (
            "* hexadecimal",
            "* uniform default",
            "dielectric name air",
            "slanted bumpmap checkerboard",
            "bitmap filename version1.tga",
            "mesh quads.ply",
            "mesh negative.obj",
            "mesh .ply.gz",
            "mesh serialized flip_tex_coords *",
            "mesh_attribute serialized",
            "perspective to_world scale(value=2) lookat",
            "perspective without fov focal_length 50mm, fov_axis x",
            "thinlens scaled",
            "version 0.6 srgb",
        ),
        "lenient",
        "Mitsuba refuses the scene",
    ),
]
