//! Errors and warnings of invalid scene files: exact messages and locations.

use crate::{Files, describe, document, problems};
use manylight_io::{LoadErrorKind, LoadOptions, check_scene, load_scene};
use std::path::Path;

/// An invalid line of XML and its problem, as `severity line:column message (help)`.
const INVALID: &[(&str, &str)] = &[
    (
        "<shape type='cyllinder'/>",
        "error 2:14 unknown shape type `cyllinder` (did you mean `cylinder`? supported types: bsplinecurve, cube, \
         cylinder, disk, instance, linearcurve, merge, obj, ply, rectangle, serialized, shapegroup, sphere)",
    ),
    (
        "<bsdf type='diffuse'><rgb name='reflectence' value='1'/></bsdf>",
        "error 2:33 bsdf `diffuse` has no parameter `reflectence` (did you mean `reflectance`?)",
    ),
    (
        "<bsdf type='null'><rgb name='xyz' value='1'/></bsdf>",
        "error 2:30 bsdf `null` has no parameter `xyz` (expected one of id)",
    ),
    (
        "<shape type='sphere'><float name='radius' value='big'/></shape>",
        "error 2:50 found `big`, expected a number",
    ),
    (
        "<shape type='sphere'><float name='radius' value='nan'/></shape>",
        "error 2:50 found `nan`, expected a number",
    ),
    (
        "<shape type='sphere'><float name='radius' value='-1'/></shape>",
        "error 2:50 `radius` of shape `sphere` must be positive",
    ),
    (
        "<shape type='sphere'><string name='radius' value='1'/></shape>",
        "error 2:51 `radius` of shape `sphere` is a string, expected a number",
    ),
    (
        "<shape type='sphere'><float name='radius' value='1'/><float name='radius' value='2'/></shape>",
        "error 2:67 the parameter `radius` is given twice",
    ),
    (
        "<shape type='sphere'><boolean name='flip_normals' value='1'/></shape>",
        "error 2:58 found `1`, expected `true` or `false`",
    ),
    (
        "<integrator type='path'><integer name='max_depth' value='2.5'/></integrator>",
        "error 2:58 found `2.5`, expected an integer",
    ),
    (
        "<integrator type='path'><integer name='max_depth' value='-2'/></integrator>",
        "error 2:58 `max_depth` of integrator `path` must be at least 0, or -1 for no limit",
    ),
    (
        "<bsdf type='diffuse' id='wood'/><shape type='sphere'><ref id='Wood'/></shape>",
        "error 2:63 no object has the id `Wood` (did you mean `wood`?)",
    ),
    (
        "<bsdf type='twosided'><ref id='none'/></bsdf>",
        "error 2:32 no object has the id `none`",
    ),
    (
        "<bsdf type='diffuse' id='a'/><bsdf type='diffuse' id='a'/>",
        "error 2:55 the id `a` is used twice",
    ),
    (
        "<shape type='sphere'><float name='radius' value='$size'/></shape>",
        "error 2:50 the parameter `$size` is not defined (define it by `-D size=...` or \
         `<default name=\"size\" value=\"...\"/>`)",
    ),
    (
        "<default name='sizes' value='1'/><shape type='sphere'><float name='radius' value='$size'/></shape>",
        "error 2:83 the parameter `$size` is not defined (did you mean `$sizes`?)",
    ),
    (
        "<shape type='obj'><string name='filename' value='seen.obj'/></shape>",
        "error 2:50 the mesh file `seen.obj` does not exist (looked for `FOLDER/seen.obj`)",
    ),
    (
        "<bsdf type='diffuse'><texture name='reflectance' type='bitmap'><string name='filename' value='a/b.png'/>\
         </texture></bsdf>",
        "error 2:95 the texture `a/b.png` does not exist (looked for `FOLDER/a/b.png`)",
    ),
    (
        "<include filename='scenes.xml'/>",
        "error 2:20 the included file `scenes.xml` does not exist (looked for `FOLDER/scenes.xml`; did you mean \
         `scene.xml`?)",
    ),
    (
        "<shape type='obj'/>",
        "error 2:14 shape `obj` needs the parameter `filename`",
    ),
    ("<shape/>", "error 2:2 <shape> needs the attribute `type`"),
    (
        "<bsdf type='twosided'/>",
        "error 2:13 bsdf `twosided` needs one or two nested bsdfs",
    ),
    (
        "<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>",
        "error 2:24 bsdf `dielectric` transmits light and cannot be nested in `twosided` (remove `twosided`: \
         transmitting materials already have two sides)",
    ),
    (
        "<bsdf type='diffuse'><bsdf type='diffuse'/></bsdf>",
        "error 2:23 bsdf `diffuse` cannot contain a bsdf",
    ),
    (
        "<shape type='sphere'><bsdf type='diffuse'/><bsdf type='diffuse'/></shape>",
        "error 2:45 shape `sphere` can have only one bsdf",
    ),
    (
        "<bsdf type='roughconductor'><string name='distribution' value='ggz'/></bsdf>",
        "error 2:64 unknown value `ggz` of `distribution` of bsdf `roughconductor` (did you mean `ggx`?)",
    ),
    (
        "<bsdf type='roughconductor'><float name='alpha_u' value='0.1'/></bsdf>",
        "error 2:13 bsdf `roughconductor` needs the parameter `alpha_v`",
    ),
    (
        "<bsdf type='roughplastic'><float name='alpha_u' value='0.1'/></bsdf>",
        "error 2:13 bsdf `roughplastic` needs the parameter `alpha_v`",
    ),
    (
        "<bsdf type='roughplastic'><float name='alpha' value='0.2'/><float name='alpha_u' value='0.1'/>\
         <float name='alpha_v' value='0.1'/></bsdf>",
        "error 2:54 `alpha` of bsdf `roughplastic` must be absent if `alpha_u` or `alpha_v` is given",
    ),
    (
        "<bsdf type='conductor'><string name='material' value='CuO3'/></bsdf>",
        "error 2:55 unknown conductor `CuO3` (did you mean `CuO`?)",
    ),
    (
        "<bsdf type='dielectric'><string name='int_ior' value='watr'/></bsdf>",
        "error 2:55 unknown dielectric `watr` (did you mean `water`?)",
    ),
    (
        "<emitter type='area'/>",
        "error 2:16 emitter `area` must be nested in a shape (move it into the <shape> that emits light)",
    ),
    (
        "<shape type='sphere'><emitter type='point'/></shape>",
        "error 2:37 emitter `point` cannot be nested in a shape; expected `area`",
    ),
    (
        "<shape type='shapegroup'><shape type='sphere'><emitter type='area'/></shape></shape>",
        "error 2:48 a shape in a shapegroup cannot have an emitter (move the shape out of the shapegroup)",
    ),
    (
        "<shape type='instance'/>",
        "error 2:14 an instance needs a reference to a shapegroup (add for example <ref id=\"...\"/>)",
    ),
    (
        "<shape type='disk'><transform name='to_world'><scale value='0'/></transform></shape>",
        "error 2:21 `to_world` of shape `disk` must be invertible",
    ),
    (
        "<shape type='disk'><transform name='to_world'><rotate angle='9'/></transform></shape>",
        "error 2:48 the axis of this rotation is zero (expected a nonzero axis, for example `y=\"1\"`)",
    ),
    (
        "<shape type='disk'><transform name='to_world'><lookat origin='0 0 0' target='0 1 0' up='0 1 0'/></transform></shape>",
        "error 2:48 this lookat defines no view (expected `target` different from `origin`, and `up` not parallel to the view \
         direction)",
    ),
    (
        "<shape type='disk'><transform name='to_world'><matrix value='1 2 3'/></transform></shape>",
        "error 2:62 found `1 2 3`, expected 9 or 16 numbers",
    ),
    (
        "<shape type='disk'><transform name='to_world'><rotat x='1'/></transform></shape>",
        "error 2:48 unknown element <rotat> in a transform (did you mean <rotate>?)",
    ),
    (
        "<flaot name='radius' value='1'/>",
        "error 2:2 unknown element <flaot> (did you mean <float>?)",
    ),
    (
        "<shape type='disk' name='a' nmae='b'/>",
        "error 2:29 <shape> has no attribute `nmae` (did you mean `name`?)",
    ),
    (
        "<shape type='disk'/> words",
        "error 2:22 unexpected text between elements (expected values in attributes, and comments in <!-- ... -->)",
    ),
    (
        "<bsdf type='phong'/>",
        "error 2:13 bsdf `phong` is supported only in files of version 0.x (use `principled`, `roughconductor` or \
         `diffuse`, or declare `<scene version=\"0.6.0\">`)",
    ),
    (
        "<bsdf type='mask' id='m'><ref id='m'/></bsdf>",
        "error 2:35 the object `m` contains itself",
    ),
    (
        "<bsdf type='principled'><float name='eta' value='1.5'/><float name='specular' value='1'/></bsdf>",
        "error 2:50 bsdf `principled` has both `eta` and `specular` (expected one of them)",
    ),
    (
        "<bsdf type='diffuse'><spectrum name='reflectance' value='500:1, 400:2'/></bsdf>",
        "error 2:58 found `500:1, 400:2`, expected one number, or pairs `wavelength:value` with increasing wavelengths",
    ),
    (
        "<sensor type='perspective'><film type='hdrfilm'><integer name='crop_width' value='900'/></film></sensor>",
        "error 2:83 the crop window 900x576 at (0, 0) exceeds the film of 768x576",
    ),
    (
        "<shape type='disk'><transform name='to_world'><rotate x='1' y='1' angle='9'/></transform></shape>",
        "warning 2:48 the axis of this rotation has length 1.414, not 1 (as in Mitsuba 3, the axis is not normalized, so \
         the transform is not a rotation)",
    ),
    (
        "<sensor type='perspective'><sampler type='independant'/></sensor>",
        "error 2:43 unknown sampler type `independant` (did you mean `independent`? supported types: halton, \
         hammersley, independent, ldsampler, multijitter, orthogonal, sobol, stratified)",
    ),
    (
        "<bsdf type='hair'/><bsdf type='hair'/>",
        "warning 2:13 bsdf `hair` is not supported; it is replaced by gray diffuse",
    ),
    (
        "<shape type='sphere'><medium name='interior' type='homogeneous'/></shape>",
        "warning 2:52 medium `homogeneous` is ignored: participating media are not supported",
    ),
    (
        "<integrator type='mine'><integer name='max_depth' value='3'/><float name='x' value='1'/></integrator>",
        "warning 2:19 unknown integrator type `mine`; only its `max_depth`, `rr_depth` and `hide_emitters` are used",
    ),
];

#[test]
fn each_mistake_gives_one_message_at_its_location() {
    let wrong: Vec<String> = INVALID
        .iter()
        .filter_map(|(xml, expected)| {
            let found = problems("3.0.0", xml);
            (found != [*expected])
                .then(|| format!("{xml}\n  found    {found:#?}\n  expected {expected:?}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn all_mistakes_are_reported_in_the_order_of_the_file() {
    let found = problems(
        "3.0.0",
        "<shape type='obj'><string name='filename' value='a.obj'/></shape>\n<bsdf type='hair'/>\n<bsdf type='difuse'/>",
    );
    let places: Vec<&str> = found
        .iter()
        .map(|text| text.split(' ').nth(1).unwrap())
        .collect();
    assert_eq!(places, ["2:50", "3:13", "4:13"]);
}

/// The problems of the scene file `scene`.
fn whole(scene: &str) -> Vec<String> {
    let files = Files::new(scene, &[]);
    check_scene(&files.scene(), &LoadOptions::default())
        .iter()
        .map(describe)
        .collect()
}

#[test]
fn invalid_documents_are_rejected() {
    assert_eq!(
        whole("<scene version='3.0.0'>\n  <shape type='sphere'>\n</scene>"),
        ["error 3:1 malformed XML: expected 'shape' tag, not 'scene'"]
    );
    assert_eq!(
        whole("<bsdf version='3.0.0' type='diffuse'/>"),
        ["error 1:2 found the root element <bsdf>, expected <scene>"]
    );
    assert_eq!(
        whole("<scene version='3.0.0'><emitter type='constant'/></scene>"),
        ["error 1:2 the scene has no sensor (add for example <sensor type=\"perspective\"/>)"]
    );
    assert_eq!(
        whole("<scene><emitter type='constant'/><sensor type='perspective'/></scene>"),
        [
            "error 1:2 <scene> needs the attribute `version` (expected for example `<scene version=\"3.0.0\">`)"
        ]
    );
    assert_eq!(
        whole("<scene version='3.0.0'><sensor type='perspective'/></scene>"),
        ["warning 1:2 the scene has no emitter; its image will be black"]
    );
}

#[test]
fn columns_count_characters_after_a_byte_order_mark() {
    let found = whole(
        "\u{feff}<!-- \u{e4}\u{f6} --><scene version='3.0.0'><emitter type='constant'/><sensor type='perspektive'/></scene>",
    );
    assert!(
        found[0].starts_with(
            "error 1:75 unknown sensor type `perspektive` (did you mean `perspective`?"
        ),
        "{found:?}"
    );
}

#[test]
fn deep_nesting_and_cyclic_inclusion_are_errors() {
    let deep = document(
        "3.0.0",
        &format!(
            "{}{}",
            "<bsdf type='twosided'>".repeat(5000),
            "</bsdf>".repeat(5000)
        ),
    );
    let found = whole(&deep);
    assert!(
        found
            .iter()
            .any(|text| text.contains("nested more than 100 deep")),
        "{found:?}"
    );
    let found = whole(&document("3.0.0", "<include filename='scene.xml'/>"));
    assert!(
        found.iter().any(|text| text.contains("includes itself")),
        "{}",
        found.len()
    );
}

#[test]
fn errors_have_kinds() {
    let kind = |scene: &Path, strict| {
        let options = LoadOptions {
            strict,
            ..LoadOptions::default()
        };
        load_scene(scene, &options).unwrap_err().kind()
    };
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(
        kind(&folder.path().join("none.xml"), false),
        LoadErrorKind::FileSystem
    );
    std::fs::write(folder.path().join("scene.blend"), "BLENDER").unwrap();
    assert_eq!(
        kind(&folder.path().join("scene.blend"), false),
        LoadErrorKind::Scene
    );
    let files = Files::new(&document("3.0.0", "<bsdf type='hair'/>"), &[]);
    assert_eq!(kind(&files.scene(), true), LoadErrorKind::Strict);
    assert_eq!(files.load().warnings.len(), 1);
}

#[test]
fn defines_that_the_scene_does_not_use_are_errors() {
    let files = Files::new(&document("3.0.0", "<default name='size' value='1'/>"), &[]);
    let options = LoadOptions {
        defines: vec![("sise".to_owned(), "2".to_owned())],
        strict: false,
        ..LoadOptions::default()
    };
    let error = load_scene(&files.scene(), &options).unwrap_err();
    assert_eq!(
        describe(error.diagnostic()),
        "error  `-D sise=2`: the scene does not use `$sise` (did you mean `size`?)"
    );
}

#[test]
fn damaged_files_are_reported_with_both_locations() {
    let scene = document(
        "3.0.0",
        "<shape type='obj'><string name='filename' value='bad.obj'/></shape>",
    );
    let files = Files::new(&scene, &[("bad.obj", "v 0 0 0\nv 1 0 x\n")]);
    let error = load_scene(&files.scene(), &LoadOptions::default()).unwrap_err();
    let at = error.diagnostic().location.as_ref().unwrap();
    assert_eq!((at.line(), at.column()), (2, 50));
    assert!(error.to_string().contains("bad.obj:2:"), "{error}");
}

#[test]
fn errors_in_included_files_name_that_file() {
    let scene = document("3.0.0", "<include filename='part.xml'/>");
    let files = Files::new(
        &scene,
        &[(
            "part.xml",
            "<scene version='3.0.0'>\n<bsdf type='difuse'/></scene>",
        )],
    );
    let error = load_scene(&files.scene(), &LoadOptions::default()).unwrap_err();
    let at = error.diagnostic().location.as_ref().unwrap();
    assert!(at.path().ends_with("part.xml"));
    assert_eq!((at.line(), at.column()), (2, 13));
}

#[test]
fn printed_errors_have_an_excerpt() {
    let files = Files::new(&document("3.0.0", "<bsdf type='difuse'/>"), &[]);
    let error = load_scene(&files.scene(), &LoadOptions::default()).unwrap_err();
    let mut text = String::new();
    miette::NarratableReportHandler::new()
        .render_report(&mut text, &error)
        .unwrap();
    for part in [
        "<bsdf type='difuse'/>",
        "line 2",
        "no bsdf plugin has this name",
        "did you mean `diffuse`?",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn backslashes_and_other_case_in_file_names_give_a_warning() {
    let scene = document(
        "3.0.0",
        "<shape type='obj'><string name='filename' value='.\\Part.OBJ'/></shape>",
    );
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let warnings = Files::new(&scene, &[("part.obj", mesh)]).load().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].message().contains("`.\\Part.OBJ`"),
        "{}",
        warnings[0]
    );
}
