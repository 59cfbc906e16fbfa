//! Embree 4 as an opponent, where the variable `MANYLIGHT_EMBREE` names its library. Declared by hand after Embree's
//! headers, only as far as it is used here.
#![allow(
    unsafe_code,
    reason = "calls into a C library, which no product code depends on"
)]

use libloading::{Library, Symbol};
use manylight::geometry::{Ray, Segment};
use manylight::math::Vec3;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicIsize, Ordering};

const INVALID: u32 = u32::MAX;
const COHERENT: c_int = 1 << 16;
const FLOAT3: c_int = 0x9003;
const UINT3: c_int = 0x5003;

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

/// Rays in structure-of-arrays form.
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

type Handle = *mut c_void;
type Trace1 = unsafe extern "C" fn(Handle, *mut RayHit1, *mut Arguments);
/// `N` rays, which the pointer in the middle leads to.
type TracePacket = unsafe extern "C" fn(*const c_int, Handle, *mut c_void, *mut Arguments);

static ALLOCATED: AtomicIsize = AtomicIsize::new(0);

extern "C" fn count_bytes(_: *mut c_void, bytes: isize, _post: bool) -> bool {
    ALLOCATED.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// A scene in Embree.
pub(crate) struct Embree {
    scene: Handle,
    intersect1: Trace1,
    occluded1: Trace1,
    occluded8: TracePacket,
    occluded16: TracePacket,
    /// Bytes allocated, vertices and indices included.
    pub(crate) bytes: isize,
    /// Time of the build.
    pub(crate) seconds: f64,
}

impl Embree {
    /// Builds over `triangles`, if the library is at hand. `threads` 0 is all.
    pub(crate) fn new(triangles: &[[Vec3; 3]], threads: usize) -> Option<Self> {
        let path = std::env::var_os("MANYLIGHT_EMBREE")?;
        ALLOCATED.store(0, Ordering::Relaxed);
        // SAFETY: the user names Embree 4's library; its functions have the signatures that are declared here, the buffers
        // have the sizes that are passed with them, and handles are used only while their owner lives.
        unsafe {
            let library = Library::new(path).expect("MANYLIGHT_EMBREE is no library");
            macro_rules! function {
                ($name:literal: $type:ty) => {{
                    let symbol: Symbol<$type> = library
                        .get($name)
                        .expect("the library lacks an Embree 4 function");
                    *symbol
                }};
            }
            let new_device =
                function!(b"rtcNewDevice\0": unsafe extern "C" fn(*const c_char) -> Handle);
            let monitor = function!(b"rtcSetDeviceMemoryMonitorFunction\0":
                unsafe extern "C" fn(Handle, extern "C" fn(*mut c_void, isize, bool) -> bool, *mut c_void));
            let new_scene = function!(b"rtcNewScene\0": unsafe extern "C" fn(Handle) -> Handle);
            let new_geometry =
                function!(b"rtcNewGeometry\0": unsafe extern "C" fn(Handle, c_int) -> Handle);
            let new_buffer = function!(b"rtcSetNewGeometryBuffer\0":
                unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void);
            let commit_geometry = function!(b"rtcCommitGeometry\0": unsafe extern "C" fn(Handle));
            let attach =
                function!(b"rtcAttachGeometry\0": unsafe extern "C" fn(Handle, Handle) -> c_uint);
            let commit = function!(b"rtcCommitScene\0": unsafe extern "C" fn(Handle));

            let config = std::ffi::CString::new(format!("threads={threads}"))
                .expect("invariant: no zero inside");
            let device = new_device(config.as_ptr());
            assert!(!device.is_null(), "Embree makes no device");
            monitor(device, count_bytes, null_mut());
            let scene = new_scene(device);
            let geometry = new_geometry(device, 0);
            let vertices = new_buffer(geometry, 1, 0, FLOAT3, 12, 3 * triangles.len());
            let indices = new_buffer(geometry, 0, 0, UINT3, 12, triangles.len());
            assert!(!vertices.is_null() && !indices.is_null());
            let vertices =
                std::slice::from_raw_parts_mut(vertices.cast::<[f32; 3]>(), 3 * triangles.len());
            for (out, p) in vertices.iter_mut().zip(triangles.iter().flatten()) {
                *out = p.to_array();
            }
            let indices =
                std::slice::from_raw_parts_mut(indices.cast::<u32>(), 3 * triangles.len());
            for (out, i) in indices.iter_mut().zip(0..) {
                *out = i;
            }
            commit_geometry(geometry);
            attach(scene, geometry);
            let start = std::time::Instant::now();
            commit(scene);
            let seconds = start.elapsed().as_secs_f64();
            let embree = Embree {
                scene,
                intersect1: function!(b"rtcIntersect1\0": Trace1),
                occluded1: function!(b"rtcOccluded1\0": Trace1),
                occluded8: function!(b"rtcOccluded8\0": TracePacket),
                occluded16: function!(b"rtcOccluded16\0": TracePacket),
                bytes: ALLOCATED.load(Ordering::Relaxed),
                seconds,
            };
            // Its threads may still run: never unload it.
            std::mem::forget(library);
            Some(embree)
        }
    }

    /// Distance of the nearest hit; infinite without one.
    pub(crate) fn intersect(&self, ray: &Ray) -> f32 {
        let mut query = single(ray.o, ray.d, ray.t_max);
        // SAFETY: the structures have Embree's layout (with room to spare) and live through the call.
        unsafe { (self.intersect1)(self.scene, &mut query, &mut Arguments::new(0)) };
        if query.geometry == INVALID {
            f32::INFINITY
        } else {
            query.t_far
        }
    }

    /// Whether anything lies on the segment.
    pub(crate) fn occluded(&self, segment: &Segment) -> bool {
        let mut query = single(segment.from, segment.to - segment.from, 1.0);
        // SAFETY: as above.
        unsafe { (self.occluded1)(self.scene, &mut query, &mut Arguments::new(0)) };
        query.t_far < 0.0
    }

    /// Visibility from `from` to 8 or 16 points (coordinate by coordinate), those in `wanted`; the blocked as bits.
    #[inline]
    pub(crate) fn occluded_packet<const N: usize>(
        &self,
        from: Vec3,
        to: &[[f32; N]; 3],
        wanted: u32,
        coherent: bool,
    ) -> u32 {
        #[repr(align(64))]
        struct Aligned<const N: usize>([c_int; N]);
        let valid: Aligned<N> = Aligned(std::array::from_fn(|i| -((wanted >> i & 1) as c_int)));
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
        let mut arguments = Arguments::new(if coherent { COHERENT } else { 0 });
        let trace = match N {
            8 => self.occluded8,
            16 => self.occluded16,
            _ => panic!("packets have 8 or 16 rays"),
        };
        // SAFETY: as above; the function is that for `N` rays, and masks and rays are aligned as Embree asks.
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
