//! A viewer with tev's protocol, written from the description in tev's header `Ipc.h`: it reads
//! packets from one connection and keeps images.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::thread::JoinHandle;

/// An image in the viewer.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TevImage {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Channels in the order of their creation, with their pixels row by row.
    pub(super) channels: Vec<(String, Vec<f32>)>,
    /// Number of updates of the pixel in the upper left corner.
    pub(super) updates: usize,
}

impl TevImage {
    pub(super) fn channel(&self, name: &str) -> &[f32] {
        let found = self.channels.iter().find(|channel| channel.0 == name);
        &found.unwrap_or_else(|| panic!("no channel {name}")).1
    }
}

/// What a viewer holds when its client has gone.
#[derive(Debug, Default)]
pub(super) struct Received {
    pub(super) images: BTreeMap<String, TevImage>,
    /// Number of images that were created or replaced.
    pub(super) created: usize,
}

/// Listens at a free port of `host` and reads from the first client until it closes the connection.
pub(super) fn listen(host: &str) -> (SocketAddr, JoinHandle<Received>) {
    let listener = TcpListener::bind((host, 0)).unwrap();
    let address = listener.local_addr().unwrap();
    let reader = std::thread::spawn(move || {
        let (stream, _) = listener.accept().unwrap();
        read_all(stream)
    });
    (address, reader)
}

/// Reads until the client closes the connection.
pub(super) fn read_all(mut stream: TcpStream) -> Received {
    let mut received = Received::default();
    while let Some(packet) = read_packet(&mut stream) {
        received.apply(&packet);
    }
    received
}

/// The rest of a packet after its length; `None` at the end of the connection between two packets.
pub(super) fn read_packet(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut length = [0; 4];
    match stream.read_exact(&mut length) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return None,
        result => result.unwrap(),
    }
    // The length counts itself.
    let mut packet = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut packet).unwrap();
    Some(packet)
}

impl Received {
    pub(super) fn apply(&mut self, packet: &[u8]) {
        let mut fields = Fields(packet);
        match fields.byte() {
            4 => self.create(&mut fields),
            6 => self.update(&mut fields),
            kind => panic!("a packet of type {kind}"),
        }
        assert!(fields.0.is_empty(), "{} bytes are left", fields.0.len());
    }

    fn create(&mut self, fields: &mut Fields) {
        assert_eq!(fields.byte(), 1, "a new image is selected");
        let name = fields.text();
        let (width, height) = (fields.integer(), fields.integer());
        let count = fields.integer();
        let channels = (0..count).map(|_| (fields.text(), vec![0.0; width * height]));
        let image = TevImage {
            width,
            height,
            channels: channels.collect(),
            updates: 0,
        };
        self.images.insert(name, image);
        self.created += 1;
    }

    fn update(&mut self, fields: &mut Fields) {
        assert_eq!(fields.byte(), 0, "an update does not select its image");
        let name = fields.text();
        let count = fields.integer();
        let names: Vec<String> = (0..count).map(|_| fields.text()).collect();
        let [x, y, width, height] = std::array::from_fn(|_| fields.integer());
        let offsets: Vec<usize> = (0..count).map(|_| fields.long()).collect();
        let strides: Vec<usize> = (0..count).map(|_| fields.long()).collect();
        let values = fields.floats();
        let last = (0..count).map(|c| offsets[c] + (width * height - 1) * strides[c]);
        assert_eq!(values.len(), last.max().unwrap() + 1);
        let image = self.images.get_mut(&name).expect("the image was created");
        for (c, name) in names.iter().enumerate() {
            let channel = image.channels.iter_mut().find(|channel| channel.0 == *name);
            let (_, pixels) = channel.expect("the channel was created");
            for i in 0..width * height {
                let place = (y + i / width) * image.width + x + i % width;
                pixels[place] = values[offsets[c] + i * strides[c]];
            }
        }
        image.updates += usize::from(x == 0 && y == 0);
    }
}

/// The fields of a packet that are not read yet.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_first_chunk().expect("the packet goes on");
        self.0 = rest;
        *first
    }

    fn byte(&mut self) -> u8 {
        u8::from_le_bytes(self.bytes())
    }

    fn integer(&mut self) -> usize {
        i32::from_le_bytes(self.bytes()).try_into().unwrap()
    }

    fn long(&mut self) -> usize {
        i64::from_le_bytes(self.bytes()).try_into().unwrap()
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).unwrap();
        let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
        self.0 = &self.0[end + 1..];
        text
    }

    fn floats(&mut self) -> Vec<f32> {
        let (floats, []) = std::mem::take(&mut self.0).as_chunks() else {
            panic!("a part of a value");
        };
        floats
            .iter()
            .map(|&bytes| f32::from_le_bytes(bytes))
            .collect()
    }
}
