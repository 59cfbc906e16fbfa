"""Differences with named causes: patterns of case names, the kind of the cause, and the cause.

Kinds: `ours` and `theirs` (the values of that program are wrong), `lenient` (we read what Mitsuba refuses), `approximated` (a limit
that docs/formats/mitsuba.md states, with a warning), `unsupported` (with one warning), `unexplained`.
"""

KNOWN: list[tuple[tuple[str, ...], str, str]] = [
    (("conductor material AlSb*",), "theirs", "red is not a number at normal incidence, where eta and k are 0; ours is 0.996"),
    (
        ("nested blend of glass", "nested blend of blends", "texture as coloured weight", "texture as gray weight, sRGB"),
        "theirs",
        "a specular part of a `blendbsdf` is too dark: findings/mitsuba-specular-part-of-a-blend.sh",
    ),
    (
        ("lamp cube textured",),
        "theirs",
        "samples of points on the textured emission of a cube: without them, its picture is ours",
    ),
    (
        ("envmap scaled transform", "envmap stretched transform"),
        "theirs",
        "a scale in `to_world` distorts the map: findings/mitsuba-scaled-envmap.sh; it has no effect here, with one warning",
    ),
    (("slanted * flags",), "unsupported", "`flip_invalid_normals` and `use_shadowing_function` are always true"),
    (
        ("path hide_emitters behind a mask",),
        "theirs",
        "of what a masked sphere reflects, a part is missing: at opacity 0.4 it is 0.29 of the opaque picture, here 0.40",
    ),
    (("slanted normalmap of a bumpmap",), "ours", "bumps within a normal map are one tilt of the normal with one shadowing here, two in Mitsuba"),
    (
        ("principledthin spec_trans 1.0",),
        "theirs",
        "transmission is dropped for a part of the pairs of directions: findings/mitsuba-principledthin-is-not-reciprocal.sh",
    ),
    (("version 0.6 rotation",), "theirs", "Mitsuba 3 does not normalize the axis in files of 0.x, which 0.6 did"),
    (("mesh_attribute vertex bytes",), "theirs", "colors of 8 bits are taken as 0 to 255; we read fractions and warn"),
    (("bsdf pplastic", "bsdf hair"), "unsupported", "replaced by gray diffuse"),
    (("volume texture gridvolume",), "unsupported", "a constant"),
    (("timed_sunsky", "directionalarea"), "unsupported", "ignored"),
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
