//! Embree 4, loaded from the shared library that `MANYLIGHT_EMBREE` names. The declarations follow
//! Embree's headers and cover only what is called here.
#![allow(
    unsafe_code,
    reason = "calls into a C library; only this benchmark depends on it"
)]

use libloading::{Library, Symbol};
use manylight::geometry::{Ray, Segment};
use manylight::math::Vec3;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicIsize, Ordering};

/// `RTC_INVALID_GEOMETRY_ID`.
const INVALID: u32 = u32::MAX;
/// `RTC_RAY_QUERY_FLAG_COHERENT`.
const COHERENT: c_int = 1 << 16;
/// `RTC_GEOMETRY_TYPE_TRIANGLE`.
const TRIANGLES: c_int = 0;
/// `RTC_BUFFER_TYPE_INDEX` and `RTC_BUFFER_TYPE_VERTEX`.
const INDEX_BUFFER: c_int = 0;
const VERTEX_BUFFER: c_int = 1;
/// `RTC_FORMAT_FLOAT3` and `RTC_FORMAT_UINT3`.
const FLOAT3: c_int = 0x9003;
const UINT3: c_int = 0x5003;

/// `RTCRayHit`, and padding.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RayHit1 {
    o: [f32; 3],
    t_near: f32,
    d: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    ng: [f32; 3],
    uv: [f32; 2],
    primitive: u32,
    geometry: u32,
    instance: [u32; 4],
}

/// `RTCRay8` or `RTCRay16`: rays in structure-of-arrays form.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct Rays<const N: usize> {
    o: [[f32; N]; 3],
    t_near: [f32; N],
    d: [[f32; N]; 3],
    time: [f32; N],
    t_far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
}

/// `RTCRayHit16`.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct RayHit16 {
    rays: Rays<16>,
    ng: [[f32; 16]; 3],
    uv: [[f32; 16]; 2],
    primitive: [u32; 16],
    geometry: [u32; 16],
    instance: [[u32; 16]; 2],
}

/// `RTCIntersectArguments` or `RTCOccludedArguments`, and padding.
#[repr(C)]
struct Arguments {
    flags: c_int,
    features: c_uint,
    context: *mut c_void,
    filter: *const c_void,
    callback: *const c_void,
    min_width: f32,
    padding: [u32; 8],
}

impl Arguments {
    fn new(flags: c_int) -> Self {
        Arguments {
            flags,
            features: u32::MAX,
            context: null_mut(),
            filter: null(),
            callback: null(),
            min_width: 0.0,
            padding: [0; 8],
        }
    }
}

/// `RTCDevice`, `RTCScene` or `RTCGeometry`.
type Handle = *mut c_void;
/// `rtcReleaseDevice`, `rtcReleaseScene` or `rtcReleaseGeometry`.
type Release = unsafe extern "C" fn(Handle);
/// `rtcIntersect1` or `rtcOccluded1`.
type Trace1 = unsafe extern "C" fn(Handle, *mut RayHit1, *mut Arguments);
/// `rtcOccluded8` or `rtcOccluded16`: validity of each ray, scene, rays, arguments.
type TracePacket = unsafe extern "C" fn(*const c_int, Handle, *mut c_void, *mut Arguments);

/// Bytes that Embree holds, as its memory monitor reports them.
static ALLOCATED: AtomicIsize = AtomicIsize::new(0);

extern "C" fn count_bytes(_: *mut c_void, bytes: isize, _post: bool) -> bool {
    ALLOCATED.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// Whether a packet query is flagged as coherent.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Coherence {
    Coherent,
    Incoherent,
}

impl Coherence {
    fn arguments(self) -> Arguments {
        Arguments::new(match self {
            Coherence::Coherent => COHERENT,
            Coherence::Incoherent => 0,
        })
    }
}

/// Validity of each ray of a packet: -1 or 0.
#[repr(align(64))]
struct Valid<const N: usize>([c_int; N]);

/// The first `count` rays of a packet as valid.
fn first_valid(count: usize) -> Valid<16> {
    Valid(std::array::from_fn(|i| -c_int::from(i < count)))
}

/// A scene in Embree.
pub(crate) struct Embree {
    scene: Handle,
    device: Handle,
    release_scene: Release,
    release_device: Release,
    intersect1: Trace1,
    occluded1: Trace1,
    occluded8: TracePacket,
    occluded16: TracePacket,
    intersect16: TracePacket,
    /// Bytes allocated, vertices and indices included.
    pub(crate) bytes: isize,
    /// Time of the build.
    pub(crate) seconds: f64,
}

/// The function `$name` of `$library` as a function pointer of type `$type`.
macro_rules! function {
    ($library:expr, $name:literal: $type:ty) => {{
        let symbol: Symbol<$type> = $library
            .get($name)
            .expect("the library that MANYLIGHT_EMBREE names is not Embree 4");
        *symbol
    }};
}

impl Embree {
    /// Builds a scene of `triangles` with this number of threads, 0 for all. `None` if
    /// `MANYLIGHT_EMBREE` is not set.
    pub(crate) fn new(triangles: &[[Vec3; 3]], threads: usize) -> Option<Self> {
        let path = std::env::var_os("MANYLIGHT_EMBREE")?;
        ALLOCATED.store(0, Ordering::Relaxed);
        // SAFETY: the user names the library of Embree 4. Its functions have the signatures
        // declared here. The scene keeps its geometry; scene and device are released when the
        // result is dropped.
        unsafe {
            let library = Library::new(path).expect("MANYLIGHT_EMBREE is not a shared library");
            let new_scene =
                function!(library, b"rtcNewScene\0": unsafe extern "C" fn(Handle) -> Handle);
            let attach = function!(library, b"rtcAttachGeometry\0":
                unsafe extern "C" fn(Handle, Handle) -> c_uint);
            let commit = function!(library, b"rtcCommitScene\0": unsafe extern "C" fn(Handle));
            let device = new_device(&library, threads);
            let scene = new_scene(device);
            let geometry = new_geometry(&library, device, triangles);
            attach(scene, geometry);
            function!(library, b"rtcReleaseGeometry\0": Release)(geometry);
            let start = std::time::Instant::now();
            commit(scene);
            let seconds = start.elapsed().as_secs_f64();
            let embree = Embree {
                scene,
                device,
                release_scene: function!(library, b"rtcReleaseScene\0": Release),
                release_device: function!(library, b"rtcReleaseDevice\0": Release),
                intersect1: function!(library, b"rtcIntersect1\0": Trace1),
                occluded1: function!(library, b"rtcOccluded1\0": Trace1),
                occluded8: function!(library, b"rtcOccluded8\0": TracePacket),
                occluded16: function!(library, b"rtcOccluded16\0": TracePacket),
                intersect16: function!(library, b"rtcIntersect16\0": TracePacket),
                bytes: ALLOCATED.load(Ordering::Relaxed),
                seconds,
            };
            // Threads of the library may still run, so it is never unloaded.
            std::mem::forget(library);
            Some(embree)
        }
    }

    /// Distance of the nearest hit; infinite without one.
    pub(crate) fn intersect(&self, ray: &Ray) -> f32 {
        let mut query = single(ray.o, ray.d, ray.t_max);
        // SAFETY: the structures have Embree's layout and outlive the call.
        unsafe { (self.intersect1)(self.scene, &mut query, &mut Arguments::new(0)) };
        if query.geometry == INVALID {
            f32::INFINITY
        } else {
            query.t_far
        }
    }

    /// Whether the segment is occluded.
    pub(crate) fn occluded(&self, segment: &Segment) -> bool {
        let mut query = single(segment.from, segment.to - segment.from, 1.0);
        // SAFETY: as in `intersect`.
        unsafe { (self.occluded1)(self.scene, &mut query, &mut Arguments::new(0)) };
        query.t_far < 0.0
    }

    /// Distances of the nearest hits of up to 16 rays; infinite without one.
    pub(crate) fn intersect16(&self, rays: &[Ray], coherence: Coherence) -> [f32; 16] {
        let at = |lane: usize| &rays[lane.min(rays.len() - 1)];
        let mut query = RayHit16 {
            rays: packet(
                rays.len(),
                |lane| (at(lane).o, at(lane).d),
                |lane| at(lane).t_max,
            ),
            ng: [[0.0; 16]; 3],
            uv: [[0.0; 16]; 2],
            primitive: [INVALID; 16],
            geometry: [INVALID; 16],
            instance: [[INVALID; 16]; 2],
        };
        let valid = first_valid(rays.len());
        // SAFETY: as in `intersect`; the function takes 16 rays, and masks and rays have the
        // alignment that Embree requires.
        unsafe {
            let query = (&raw mut query).cast();
            (self.intersect16)(
                valid.0.as_ptr(),
                self.scene,
                query,
                &mut coherence.arguments(),
            );
        }
        std::array::from_fn(|lane| {
            if query.geometry[lane] == INVALID {
                f32::INFINITY
            } else {
                query.rays.t_far[lane]
            }
        })
    }

    /// The occluded ones of up to 16 segments, as bits.
    pub(crate) fn occluded16(&self, segments: &[Segment], coherence: Coherence) -> u32 {
        let at = |lane: usize| &segments[lane.min(segments.len() - 1)];
        let ray = |lane| (at(lane).from, at(lane).to - at(lane).from);
        let mut query = packet(segments.len(), ray, |_| 1.0);
        let valid = first_valid(segments.len());
        // SAFETY: as in `intersect16`.
        unsafe {
            let query = (&raw mut query).cast();
            (self.occluded16)(
                valid.0.as_ptr(),
                self.scene,
                query,
                &mut coherence.arguments(),
            );
        }
        let t_far = query.t_far[..segments.len()].iter().rev();
        t_far.fold(0, |bits, &t| bits << 1 | u32::from(t < 0.0))
    }

    /// Traces segments from `from` to the points `to` (structure of arrays, `N` is 8 or 16) with a
    /// bit in `wanted`. Returns the occluded ones as bits.
    #[inline]
    pub(crate) fn occluded_packet<const N: usize>(
        &self,
        from: Vec3,
        to: &[[f32; N]; 3],
        wanted: u32,
        coherence: Coherence,
    ) -> u32 {
        let valid: Valid<N> = Valid(std::array::from_fn(|i| -((wanted >> i & 1) as c_int)));
        let mut rays = Rays {
            o: from.to_array().map(|x| [x; N]),
            t_near: [0.0; N],
            d: std::array::from_fn(|a| std::array::from_fn(|i| to[a][i] - from[a])),
            time: [0.0; N],
            t_far: [1.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
        };
        let mut arguments = coherence.arguments();
        let trace = match N {
            8 => self.occluded8,
            16 => self.occluded16,
            _ => panic!("packets have 8 or 16 rays"),
        };
        // SAFETY: as in `intersect`; the function takes `N` rays, and masks and rays have the
        // alignment that Embree requires.
        unsafe {
            let rays = (&raw mut rays).cast();
            trace(valid.0.as_ptr(), self.scene, rays, &mut arguments);
        }
        let blocked = rays
            .t_far
            .iter()
            .rev()
            .fold(0, |b, &t| b << 1 | u32::from(t < 0.0));
        blocked & wanted
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: both handles are valid, and nobody else holds them.
        unsafe {
            (self.release_scene)(self.scene);
            (self.release_device)(self.device);
        }
    }
}

/// # Safety
/// `library` is Embree 4.
unsafe fn new_device(library: &Library, threads: usize) -> Handle {
    // SAFETY: the signatures are Embree 4's; `config` outlives the call.
    unsafe {
        let new_device =
            function!(library, b"rtcNewDevice\0": unsafe extern "C" fn(*const c_char) -> Handle);
        let set_monitor = function!(library, b"rtcSetDeviceMemoryMonitorFunction\0":
            unsafe extern "C" fn(Handle, extern "C" fn(*mut c_void, isize, bool) -> bool, *mut c_void));
        // Embree takes the best instruction set of the machine unless told otherwise.
        let isa = std::env::var("MANYLIGHT_EMBREE_ISA")
            .map_or(String::new(), |isa| format!(",isa={isa}"));
        let config = std::ffi::CString::new(format!("threads={threads}{isa}"))
            .expect("invariant: no zero byte inside");
        let device = new_device(config.as_ptr());
        assert!(!device.is_null(), "Embree cannot create a device");
        set_monitor(device, count_bytes, null_mut());
        device
    }
}

/// A committed geometry of `triangles`.
///
/// # Safety
/// `library` is Embree 4, and `device` is one of its devices.
unsafe fn new_geometry(library: &Library, device: Handle, triangles: &[[Vec3; 3]]) -> Handle {
    let count = 3 * triangles.len();
    // SAFETY: the signatures are Embree 4's. Both buffers have room for `count` items and are alive
    // until the geometry is released.
    unsafe {
        let new_geometry = function!(library, b"rtcNewGeometry\0":
            unsafe extern "C" fn(Handle, c_int) -> Handle);
        let new_buffer = function!(library, b"rtcSetNewGeometryBuffer\0":
            unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void);
        let commit_geometry =
            function!(library, b"rtcCommitGeometry\0": unsafe extern "C" fn(Handle));
        let geometry = new_geometry(device, TRIANGLES);
        let vertices = new_buffer(geometry, VERTEX_BUFFER, 0, FLOAT3, 12, count);
        let indices = new_buffer(geometry, INDEX_BUFFER, 0, UINT3, 12, triangles.len());
        assert!(!vertices.is_null() && !indices.is_null());
        let vertices = std::slice::from_raw_parts_mut(vertices.cast::<[f32; 3]>(), count);
        for (out, p) in vertices.iter_mut().zip(triangles.iter().flatten()) {
            *out = p.to_array();
        }
        let indices = std::slice::from_raw_parts_mut(indices.cast::<u32>(), count);
        for (out, i) in indices.iter_mut().zip(0..) {
            *out = i;
        }
        commit_geometry(geometry);
        geometry
    }
}

/// Sixteen rays as Embree takes them, of which `count` are traced: their origins and directions,
/// and their ends.
fn packet(
    count: usize,
    ray: impl Fn(usize) -> (Vec3, Vec3),
    t_far: impl Fn(usize) -> f32,
) -> Rays<16> {
    let mut rays = Rays {
        o: [[0.0; 16]; 3],
        t_near: [0.0; 16],
        d: [[0.0; 16]; 3],
        time: [0.0; 16],
        t_far: [0.0; 16],
        mask: [u32::MAX; 16],
        id: [0; 16],
        flags: [0; 16],
    };
    for lane in 0..count {
        let (o, d) = ray(lane);
        for axis in 0..3 {
            rays.o[axis][lane] = o[axis];
            rays.d[axis][lane] = d[axis];
        }
        rays.t_far[lane] = t_far(lane);
    }
    rays
}

/// One ray as Embree takes it.
fn single(o: Vec3, d: Vec3, t_far: f32) -> RayHit1 {
    RayHit1 {
        o: o.to_array(),
        t_near: 0.0,
        d: d.to_array(),
        time: 0.0,
        t_far,
        mask: u32::MAX,
        id: 0,
        flags: 0,
        ng: [0.0; 3],
        uv: [0.0; 2],
        primitive: INVALID,
        geometry: INVALID,
        instance: [INVALID; 4],
    }
}
