//! Errors and warnings of invalid PBRT scenes: exact messages and locations.

use super::{PbrtFiles, document, problems};
use manylight_io::{LoadErrorKind, LoadOptions, Severity, check_scene, load_scene};

/// An invalid line and its problem, as `severity line:column message (help)`.
const INVALID: &[(&str, &str)] = &[
    (
        "Shape \"sphere\" \"float radius\" [ 1 ] \"string x",
        "error 2:37 found the end of the line in a string, expected `\"`",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0",
        "error 3:1 found the end of the file, expected `]`",
    ),
    (
        "Shape \"sphere\" \"float radius\" [ 1.2.3 ]",
        "error 2:33 found `1.2.3`, expected a finite number",
    ),
    (
        "Shape \"sphere\" \"float radius\" [ 1e39 ]",
        "error 2:33 found `1e39`, expected a finite number",
    ),
    (
        "Shape \"sphere\" \"float radius\" [ nan ]",
        "error 2:33 found `nan`, expected a number",
    ),
    (
        "Shape \"sphere\" \"float radius\" \"big\"",
        "error 2:31 found `\"big\"`, expected a number",
    ),
    (
        "Shape \"sphere\" \"integer radius\" [ 1.5 ]",
        "error 2:35 found `1.5`, expected an integer",
    ),
    (
        "Shape \"sphere\" \"bool radius\" true",
        "error 2:16 `radius` of shape `sphere` is declared as `bool`, expected `float`",
    ),
    (
        "Shape \"sphere\" \"float radius\" [ 1 2 ]",
        "error 2:31 `radius` of shape `sphere` must be one value of 1 numbers, found 2 numbers",
    ),
    (
        "Shape \"sphere\" \"float radius\" -1",
        "error 2:31 `radius` of shape `sphere` must be positive",
    ),
    (
        "Shape \"sphere\" \"float radius\" 1 \"float radius\" 2",
        "error 2:33 the parameter `radius` is given twice",
    ),
    (
        "Shape \"sphere\" \"flot radius\" 1",
        "error 2:16 unknown type `flot` of a parameter (did you mean `float`?)",
    ),
    (
        "Shape \"sphere\" \"radius\" 1",
        "error 2:16 found `\"radius\"`, expected type and name of a parameter, such as \"float radius\"",
    ),
    (
        "Shape \"sphere\" \"float radios\" 1",
        "error 2:16 shape `sphere` has no parameter `radios` (did you mean `radius`?)",
    ),
    (
        "Shape sphere",
        "error 2:7 found `sphere`, expected a type in quotes",
    ),
    (
        "Shap \"sphere\"",
        "error 2:1 unknown directive `Shap` (did you mean `Shape`?)",
    ),
    (
        "Translate 1 2",
        "error 3:1 found the end of the file, expected 3 numbers",
    ),
    (
        "Transform [ 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 ]",
        "error 2:43 found `]`, expected 16 numbers",
    ),
    (
        "Scale 1 0 1",
        "error 2:1 a factor of a scale is 0, expected nonzero factors",
    ),
    (
        "LookAt 0 0 0 0 0 0 0 1 0",
        "error 2:1 the point of view, the target and the up vector do not span a frame \
         (expected three different directions)",
    ),
    (
        "Transform [ 1 0 0 0 1 0 0 0 0 0 1 0 0 0 0 1 ] Shape \"sphere\"",
        "error 2:53 the current transform is singular or too large",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 ] \"integer indices\" [ 0 1 2 ]",
        "error 2:33 `P` has 8 numbers, expected a multiple of 3 for the type `point3`",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 7 ]",
        "error 2:73 `indices` of shape `trianglemesh` must be indices of the 3 points, found 7",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 ]",
        "error 2:73 `indices` of shape `trianglemesh` must be a multiple of 3 integers, found 2",
    ),
    (
        "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"normal N\" [ 0 0 1 ]",
        "error 2:66 `N` of shape `trianglemesh` must be one value for each of the 3 points, found 1",
    ),
    (
        "Shape \"trianglemesh\"",
        "error 2:7 shape `trianglemesh` needs the parameter `P`",
    ),
    (
        "Shape \"heightfield\" \"integer nu\" 60000 \"integer nv\" 60000 \"float Pz\" [ 1 2 ]",
        "error 2:70 `Pz` of shape `heightfield` must be 60000 x 60000 numbers, found 2",
    ),
    (
        "Shape \"loopsubdiv\" \"integer levels\" 2000000000 \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]",
        "error 2:37 `levels` of shape `loopsubdiv` must be at most 10, with at most 67108864 triangles",
    ),
    (
        "AttributeEnd",
        "error 2:1 `AttributeEnd` without `AttributeBegin`",
    ),
    (
        "AttributeBegin",
        "error 2:1 `AttributeBegin` has no `AttributeEnd` before the end of the file",
    ),
    (
        "AttributeBegin TransformEnd AttributeEnd",
        "error 2:16 found `TransformEnd`, expected `AttributeEnd`",
    ),
    (
        "ObjectBegin \"a\" ObjectBegin \"b\" ObjectEnd ObjectEnd",
        "error 2:17 `ObjectBegin` inside of another object",
    ),
    (
        "ObjectBegin \"tree\" ObjectEnd ObjectInstance \"three\"",
        "error 2:45 no object has the name `three` (did you mean `tree`?)",
    ),
    (
        "CoordSysTransform \"camer\"",
        "error 2:19 no coordinate system has the name `camer` (did you mean `camera`?)",
    ),
    (
        "MakeNamedMaterial \"wood\" \"string type\" \"diffuse\" NamedMaterial \"Wood\" Shape \"sphere\"",
        "error 2:64 no material has the name `Wood` (did you mean `wood`?)",
    ),
    (
        "Material \"difuse\"",
        "error 2:10 unknown material type `difuse` (did you mean `diffuse`? known types: coatedconductor, \
         coateddiffuse, conductor, dielectric, diffuse, diffusetransmission, disney, fourier, glass, hair, interface, \
         kdsubsurface, matte, measured, metal, mirror, mix, plastic, substrate, subsurface, thindielectric, \
         translucent, uber)",
    ),
    (
        "Material \"diffuse\" \"texture reflectance\" \"wod\"",
        "error 2:42 no spectrum texture has the name `wod`",
    ),
    (
        "Texture \"a\" \"float\" \"constant\" Material \"diffuse\" \"texture reflectance\" \"a\"",
        "error 2:73 no spectrum texture has the name `a` (the texture with this name has the other type)",
    ),
    (
        "Texture \"a\" \"vector\" \"constant\"",
        "error 2:13 unknown type `vector` of a texture, expected `float` or `spectrum`",
    ),
    (
        "Material \"conductor\" \"spectrum eta\" \"metal-Cu-ets\"",
        "error 2:37 unknown spectrum `metal-Cu-ets` (did you mean `metal-Cu-eta`?)",
    ),
    (
        "Material \"diffuse\" \"spectrum reflectance\" [ 500 1 400 1 ]",
        "error 2:43 `reflectance` of material `diffuse` must be pairs of wavelength and value with increasing wavelengths",
    ),
    (
        "Material \"diffuse\" \"rgb reflectance\" [ 0.5 0.5 ]",
        "error 2:38 `reflectance` has 2 numbers, expected a multiple of 3 for the type `rgb`",
    ),
    (
        "Shape \"plymesh\" \"string filename\" \"absent.ply\"",
        "error 2:35 the mesh file `absent.ply` does not exist (looked for `FOLDER/absent.ply`)",
    ),
    (
        "Include \"scen.pbrt\"",
        "error 2:9 the included file `scen.pbrt` does not exist (looked for `FOLDER/scen.pbrt`; did you mean \
         `scene.pbrt`?)",
    ),
    (
        "Include \"scene.pbrt\"",
        "error 2:9 the file `scene.pbrt` includes itself",
    ),
    (
        "LightSource \"spot\" \"point3 from\" [ 1 1 1 ] \"point3 to\" [ 1 1 1 ]",
        "error 2:34 `from` and `to` of light `spot` must be different points",
    ),
    (
        "ColorSpace \"rgb\"",
        "error 2:12 unknown color space `rgb` (expected one of srgb, dci-p3, rec2020, aces2065-1)",
    ),
    (
        "Attribute \"shapes\" \"float radius\" 1",
        "error 2:11 unknown target `shapes` of attributes (expected shape, light, material, medium or texture)",
    ),
    (
        "MakeNamedMaterial \"a\" Shape \"sphere\"",
        "error 2:19 material `a` needs the parameter `type`",
    ),
    (
        "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"fog\" \"\"",
        "warning 2:1 participating media are not supported; they are ignored",
    ),
    (
        "Material \"hair\" Material \"hair\"",
        "warning 2:10 material `hair` is not supported; it is replaced by diffuse of its color",
    ),
    (
        "Texture \"a\" \"spectrum\" \"ptex\" \"string filename\" \"a.ptx\"",
        "warning 2:24 texture `ptex` is not supported; it is replaced by its mean",
    ),
    (
        "Texture \"a\" \"float\" \"dots\" \"string mapping\" \"conical\"",
        "error 2:45 unknown value `conical` of `mapping` of texture `dots` (expected one of uv, spherical, cylindrical, planar)",
    ),
    (
        "Texture \"a\" \"float\" \"checkerboard\" \"integer dimension\" 4",
        "error 2:56 `dimension` of texture `checkerboard` must be 2 or 3",
    ),
    (
        "Texture \"d\" \"float\" \"dots\" Texture \"a\" \"float\" \"bilerp\" \"texture v10\" \"d\"",
        "error 2:71 `v10` of texture `bilerp` must be constant, found a texture that varies",
    ),
];

#[test]
fn each_mistake_in_a_pbrt_scene_gives_one_message_at_its_location() {
    let wrong: Vec<String> = INVALID
        .iter()
        .filter_map(|(text, expected)| {
            let found = problems(text);
            (found != [*expected])
                .then(|| format!("{text}\n  found    {found:#?}\n  expected {expected:?}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn parsing_goes_on_after_a_mistake() {
    let found = problems("Shape sphere\nTranslate 1 x 3\nShap \"a\"\nShape \"spere\"");
    let places: Vec<&str> = found
        .iter()
        .map(|text| text.split(' ').nth(1).unwrap())
        .collect();
    assert_eq!(places, ["2:7", "3:13", "4:1", "5:7"]);
}

#[test]
fn bytes_that_are_not_utf8_are_located() {
    let files = PbrtFiles::new(b"Camera \"perspective\"\n# caf\xe9\nWorldBegin", &[]);
    assert_eq!(
        files.problems(),
        ["error 2:6 found a byte that is not UTF-8, expected UTF-8 text"]
    );
}

#[test]
fn damaged_compressed_and_mesh_files_are_errors() {
    let files = PbrtFiles::new(b"\x1f\x8b\x08\x00damaged", &[]);
    let found = files.problems();
    assert!(
        found[0].contains("scene.pbrt: the compressed file is damaged"),
        "{found:?}"
    );
    let scene = document("Shape \"plymesh\" \"string filename\" \"bad.ply\"");
    let files = PbrtFiles::new(
        scene.as_bytes(),
        &[("bad.ply", b"ply\nformat ascii 1.0\nelement")],
    );
    let found = files.problems();
    assert!(
        found[0].starts_with("error 2:35 cannot use the mesh file"),
        "{found:?}"
    );
    assert_eq!(found.len(), 1);
}

#[test]
fn scenes_without_camera_or_light_are_reported() {
    let files = PbrtFiles::new(b"# nothing\nWorldBegin\nLightSource \"infinite\"", &[]);
    assert_eq!(
        files.problems(),
        [
            "error 1:1 the scene has no camera (add for example `Camera \"perspective\"` before `WorldBegin`)"
        ]
    );
    let files = PbrtFiles::new(b"Camera \"perspective\" WorldBegin Shape \"sphere\"", &[]);
    assert_eq!(
        files.problems(),
        ["warning 1:1 the scene has no light; its image will be black"]
    );
}

#[test]
fn errors_of_pbrt_scenes_have_kinds() {
    let kind = |files: &PbrtFiles, strict| {
        let options = LoadOptions {
            strict,
            ..LoadOptions::default()
        };
        load_scene(&files.scene(), &options).unwrap_err().kind()
    };
    let of = |world: &str| PbrtFiles::new(document(world).as_bytes(), &[]);
    assert_eq!(kind(&of("Shape \"spere\""), false), LoadErrorKind::Scene);
    assert_eq!(kind(&of("Material \"hair\""), true), LoadErrorKind::Strict);
    let absent = of("Include \"absent.pbrt\"");
    assert_eq!(kind(&absent, false), LoadErrorKind::FileSystem);
    let absent = of("Shape \"plymesh\" \"string filename\" \"absent.ply\"");
    assert_eq!(kind(&absent, false), LoadErrorKind::FileSystem);
}

#[test]
fn damaged_scenes_do_not_panic() {
    let seed = document(
        "AttributeBegin Rotate 30 0 1 0 Texture \"t\" \"float\" \"checkerboard\" \"float uscale\" 2\n\
         Material \"coateddiffuse\" \"rgb reflectance\" [ .1 .2 .3 ] \"texture roughness\" \"t\"\n\
         AreaLightSource \"diffuse\" \"blackbody L\" 3000 \"bool twosided\" true\n\
         Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 2 ]\n\
         AttributeEnd ObjectBegin \"o\" Shape \"loopsubdiv\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]\n\
         Shape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ] ObjectEnd ObjectInstance \"o\"",
    );
    let mut state = 1_u64;
    let mut below = |limit: usize| {
        // Linear congruential generator (Knuth, MMIX).
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % limit
    };
    let files = PbrtFiles::new(seed.as_bytes(), &[]);
    for _ in 0..400 {
        let mut bytes = seed.clone().into_bytes();
        for _ in 0..=below(2) {
            let at = below(bytes.len());
            match below(4) {
                0 => bytes.truncate(at.max(1)),
                1 => drop(bytes.remove(at)),
                2 => bytes[at] = b"\"[]9- \n.e"[below(9)],
                _ => bytes[at] = bytes[below(bytes.len())],
            }
        }
        std::fs::write(files.scene(), &bytes).unwrap();
        let found = check_scene(&files.scene(), &LoadOptions::default());
        let failed = load_scene(&files.scene(), &LoadOptions::default()).is_err();
        let has_error = found.iter().any(|d| d.severity == Severity::Error);
        assert_eq!(failed, has_error, "{}", String::from_utf8_lossy(&bytes));
    }
}
