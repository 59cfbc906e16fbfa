//! The report of a render, as a JSON object and as metadata of its images.

use crate::args::DisplayArgs;
use crate::output::{human_time, print_message, print_warnings};
use crate::repeat::{Settings, command_line};
use crate::stated_error;
use manylight::film::StatedError;
use manylight::render::Stats;
use manylight_lab::text::date;
use serde_json::{Map, Value, json};
use std::time::{Duration, SystemTime};

/// Version of the shape of the JSON object.
const SCHEMA: &str = "manylight.render/1";

/// Settings, counts, times and warnings of a finished render.
#[derive(Debug)]
pub(crate) struct RenderReport<'r> {
    /// The settings.
    pub(crate) settings: Settings<'r>,
    /// Counts and times.
    pub(crate) stats: &'r Stats,
    /// Number of complete passes.
    pub(crate) passes: u32,
    /// The error that the picture states, if it is known.
    pub(crate) error: Option<StatedError>,
    /// Warnings without repetitions.
    pub(crate) warnings: Vec<String>,
    /// SHA-256 of the files of the scene.
    pub(crate) scene_digest: &'r str,
}

impl RenderReport<'_> {
    /// The object that `--json` prints.
    pub(crate) fn to_json(&self) -> Value {
        let request = self.settings.request;
        let stages = self.stats.stages();
        let stages: Map<String, Value> = stages
            .iter()
            .map(|(name, time)| (name.to_string(), json!(time.as_secs_f64())))
            .collect();
        let outputs: Vec<_> = request
            .outputs
            .iter()
            .map(|p| p.display().to_string())
            .collect();
        json!({
            "schema": SCHEMA,
            "version": env!("CARGO_PKG_VERSION"),
            "scene": request.scene.display().to_string(),
            "scene_sha256": self.scene_digest,
            "method": request.paths.method.name,
            "settings": self.settings.to_json(),
            "stages": stages,
            "counts": self.counts(),
            "error": self.error.as_ref().map(stated_error::to_json),
            "rates": self.rates(),
            "memory": { "peak_bytes": peak_bytes(), "bytes_per_light": self.bytes_per_light() },
            "clamped_share": ratio(Stats::get(&self.stats.clamped), Stats::get(&self.stats.unclamped)),
            "dropped_samples": Stats::get(&self.stats.dropped_samples),
            "warnings": self.warnings,
            "outputs": outputs,
        })
    }

    fn counts(&self) -> Value {
        let stats = self.stats;
        let size = self.settings.film.crop_size;
        json!({
            "pixels": u64::from(size.x) * u64::from(size.y),
            "passes": self.passes,
            "photons": Stats::get(&stats.photon_paths),
            "lights": Stats::get(&stats.lights),
            "connections": Stats::get(&stats.connections),
            "shadow_rays": Stats::get(&stats.shadow_rays),
            "camera_paths": Stats::get(&stats.camera_paths),
            "stored_photons": Stats::get(&stats.photons),
            "stored_importons": Stats::get(&stats.importons),
        })
    }

    /// Each rate is a count over the time of its stage; 0 if the stage was not run.
    fn rates(&self) -> Value {
        let rate = |count: u64, stage: &str| {
            let seconds = self.stage(stage).as_secs_f64();
            if seconds > 0.0 {
                count as f64 / seconds
            } else {
                0.0
            }
        };
        json!({
            "paths_per_second": rate(Stats::get(&self.stats.camera_paths), "shade"),
            "photons_per_second": rate(Stats::get(&self.stats.photon_paths), "photons"),
            "connections_per_second": rate(Stats::get(&self.stats.connections), "shade"),
        })
    }

    fn stage(&self, name: &str) -> Duration {
        let stages = self.stats.stages();
        stages
            .iter()
            .find(|stage| stage.0 == name)
            .map_or(Duration::ZERO, |stage| stage.1)
    }

    fn bytes_per_light(&self) -> f64 {
        ratio(
            Stats::get(&self.stats.light_bytes),
            Stats::get(&self.stats.lights),
        )
    }

    /// Metadata of the images (name, value), sufficient to repeat the render, without their stated
    /// error. The time of the stage `write` is not known yet.
    pub(crate) fn metadata(&self) -> Vec<(String, String)> {
        let request = self.settings.request;
        let mut entries = vec![
            (
                "software".to_string(),
                format!("manylight {}", env!("CARGO_PKG_VERSION")),
            ),
            (
                "command".into(),
                command_line(request, self.settings.choice, self.passes),
            ),
            ("scene".into(), request.scene.display().to_string()),
            ("scene.sha256".into(), self.scene_digest.into()),
            ("method".into(), request.paths.method.name.into()),
            ("passes".into(), self.passes.to_string()),
            ("samples".into(), self.passes.to_string()),
            ("capDate".into(), capture_date(SystemTime::now())),
            ("warnings".into(), self.warnings.len().to_string()),
        ];
        entries.extend(self.settings.metadata());
        let total = self.stats.total_time();
        entries.push(("seconds".into(), format!("{:.3}", total.as_secs_f64())));
        for (name, time) in self.stats.stages() {
            entries.push((
                format!("seconds.{name}"),
                format!("{:.3}", time.as_secs_f64()),
            ));
        }
        entries
    }

    /// Prints the stated error in a sentence, and what makes it uncertain.
    pub(crate) fn print_error(&self) {
        let Some(error) = &self.error else {
            return;
        };
        print_message(stated_error::sentence(error, self.passes));
        print_warnings(stated_error::doubt(error).as_slice());
    }

    /// Prints one line with the total time and the times of the longest stages; of all stages with
    /// `--verbose`.
    pub(crate) fn print_times(&self, display: DisplayArgs) {
        let stages = self.stats.stages();
        let total = self.stats.total_time().as_secs_f64();
        let is_listed = |time: &Duration| display.verbose || time.as_secs_f64() > 0.05 * total;
        let parts = stages.iter().filter(|(_, time)| is_listed(time));
        let parts: Vec<_> = parts
            .map(|(name, time)| format!("{name} {}", human_time(time.as_secs_f64())))
            .collect();
        print_message(format_args!(
            "{} pass{} in {} ({})",
            self.passes,
            if self.passes == 1 { "" } else { "es" },
            human_time(total),
            parts.join(", ")
        ));
    }
}

/// Universal time as OpenEXR's attribute `capDate` has it: `YYYY:MM:DD hh:mm:ss`.
fn capture_date(time: SystemTime) -> String {
    date(time)
        .replace('-', ":")
        .replace('T', " ")
        .replace('Z', "")
}

/// `part / whole`, or 0 if `whole` is 0.
fn ratio(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        0.0
    } else {
        part as f64 / whole as f64
    }
}

/// Peak memory of the process in bytes; 0 if the system does not report it.
fn peak_bytes() -> u64 {
    memory_status("VmHWM:")
}

/// Present memory of the process in bytes; 0 if the system does not report it.
pub(crate) fn resident_bytes() -> u64 {
    memory_status("VmRSS:")
}

/// A size in `/proc/self/status`, in bytes.
fn memory_status(key: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(key));
    let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.unwrap_or(0) * 1024
}
