//! Runs the program in a temporary folder.

use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A small open box under an area light, 16 x 12 pixels.
pub(crate) const BOX: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="0, 1, 4" target="0, 0.8, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="16"/>
            <integer name="height" value="12"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <bsdf type="diffuse" id="gray"><rgb name="reflectance" value="0.5, 0.4, 0.3"/></bsdf>
    <bsdf type="roughconductor" id="metal"><float name="alpha" value="0.2"/></bsdf>
    <shape type="rectangle">
        <transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
        <ref id="gray"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="3"/><translate z="-2"/></transform>
        <ref id="metal"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="0.5"/><rotate x="1" angle="90"/><translate y="2"/></transform>
        <emitter type="area"><rgb name="radiance" value="8, 8, 6"/></emitter>
        <ref id="gray"/>
    </shape>
</scene>
"#;

/// A temporary folder with a scene.
pub(crate) struct Folder(TempDir);

impl Folder {
    /// A folder with the file `scene.xml`.
    pub(crate) fn new(scene: &str) -> Self {
        let folder = Folder(TempDir::new().unwrap());
        std::fs::write(folder.path("scene.xml"), scene).unwrap();
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The program with these words (split at spaces), in this folder.
    pub(crate) fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_manylight"));
        command
            .args(words.split_whitespace())
            .current_dir(self.0.path());
        command.env("NO_COLOR", "1");
        // Folders for other tests.
        command
            .env_remove("MANYLIGHT_SCENES")
            .env_remove("MANYLIGHT_REFERENCES");
        command
    }

    pub(crate) fn run(&self, words: &str) -> Ended {
        Ended(self.command(words).output().unwrap())
    }

    /// Names of all files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// The result of a run of the program.
pub(crate) struct Ended(Output);

impl From<Output> for Ended {
    fn from(output: Output) -> Self {
        Ended(output)
    }
}

impl Ended {
    pub(crate) fn stdout(&self) -> String {
        String::from_utf8(self.0.stdout.clone()).unwrap()
    }

    pub(crate) fn stderr(&self) -> String {
        String::from_utf8(self.0.stderr.clone()).unwrap()
    }

    /// The exit code; `None` if a signal ended the program.
    pub(crate) fn exit_code(&self) -> Option<i32> {
        self.0.status.code()
    }

    /// Checks the exit code.
    #[track_caller]
    pub(crate) fn code(self, expected: i32) -> Self {
        assert_eq!(self.0.status.code(), Some(expected), "{}", self.stderr());
        self
    }

    /// Checks that the message contains every word.
    #[track_caller]
    pub(crate) fn says(self, words: &[&str]) -> Self {
        let text = self.stderr();
        for word in words {
            assert!(text.contains(word), "`{word}` is missing in:\n{text}");
        }
        self
    }

    /// Standard output, which must be one JSON object.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.stdout()).unwrap()
    }
}
