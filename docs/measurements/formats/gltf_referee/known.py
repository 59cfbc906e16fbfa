"""Differences with named causes: patterns of case names, the kind of the cause, and the cause.

Kinds: `ours` and `theirs` (that program does otherwise than the specification), `approximated` (a limit or another model that
docs/formats/gltf.md states), `open` (the specification does not say).
"""

FACETS = "light that facets reflect more than once is missing here, as in the specification"
BASE = "Cycles weights the diffuse part by one minus the albedo of the interface towards the viewer"
PANE = "Cycles has no thin walls: Blender's importer makes solid glass of panes"
COAT = "what is below the coat loses light on the way in and out here, in Cycles on the way out alone"

KNOWN: list[tuple[tuple[str, ...], str, str]] = [
    (
        (
            "normal texture with tangents, w 1",
            "normal texture with tangents, w -1",
        ),
        "theirs",
        "Blender's importer ignores `TANGENT`",
    ),
    (
        ("perspective znear",),
        "approximated",
        "the shading normal tells the sides of a surface, as in Mitsuba: smooth normals let about 1e-3 of the light into a closed ball",
    ),
    (("base color texture linear", "emission texture linear"), "theirs", "Cycles filters sRGB values; the specification, linear ones"),
    (("normal texture scale 0.4",), "theirs", "Cycles moves the z of the normal towards 1 if the scale is below 1"),
    (("emission of a back face, doubleSided False",), "theirs", "surfaces emit on both sides, whatever the file says"),
    (("iridescence *", "diffuse transmission", "transmission with dispersion"), "theirs", "Blender's importer does not read the extension"),
    (
        ("anisotropy rotation 0", "anisotropy rotation 90"),
        "theirs",
        "Blender's importer takes the strength for Blender's anisotropy, which has another formula",
    ),
    (("transmission absorbing",), "theirs", "Blender's importer makes 1 - color the absorption of the distance, not -ln(color)"),
    (("transmission pane roughness *", "transmission pane, color", "transmission thin ball"), "theirs", PANE),
    (("node matrix that shears",), "theirs", "Blender's importer drops the shear of a matrix"),
    (
        ("skin that tilts triangles",),
        "theirs",
        "Blender turns the normals of the file with the triangles that a skin bends; the specification, by the matrices of the joints",
    ),
    (("point lamp without intensity",), "theirs", "Blender's importer does not set the default of 1"),
    (("spot lamp, inner 0.4",), "theirs", "Blender's importer takes the part of the angle between the cones for a part of its cosine"),
    (
        (
            "no material factors",
            "metal roughness 0.6",
            "metal roughness 1.0",
            "black dielectric roughness 0.6",
            "black dielectric roughness 1.0",
            "clearcoat rough*",
            "transmission solid roughness 0.3",
            "transmission pane in white, *",
        ),
        "approximated",
        FACETS,
    ),
    (("dielectric roughness *", "transmission 0.5", "transmission texture"), "approximated", BASE),
    (("clearcoat over matte", "clearcoat over metal", "clearcoat without the bumps of its base"), "approximated", COAT),
    (("ior 0",), "approximated", "the reflectance of a dielectric at normal incidence is 0.98 at most, without a warning"),
    (
        ("specular texture",),
        "approximated",
        "textures tint the reflectance at normal incidence; a factor alone is an index of refraction, as in Cycles",
    ),
    (("sheen *",), "approximated", "another lobe, with a warning"),
    (("anisotropy rotation 45", "anisotropy texture of strengths"), "approximated", "directions along the axes alone, with a warning"),
    (("unlit",), "approximated", "emission of the base color, with a warning; the camera sees the same"),
    (("normal texture of a ball",), "open", "the silhouette, where bent normals face away from the viewer"),
    (("node uneven scale, normal texture",), "open", "bumps are bent after the scale of the node here, before it in Cycles"),
]
