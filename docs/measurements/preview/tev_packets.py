"""Compares what `manylight render --preview tev` sends with what tev's own client sends for the same pictures, byte by byte.

Usage: python tev_packets.py SCENE [OPTIONS OF render ...]        (MANYLIGHT names the program; default: manylight)

Stands in for tev: reads packets from a socket, as the header `Ipc.h` of tev describes them, and keeps the image. Each complete picture is then
sent by the Python package tevclient to another socket. Both streams must be equal, and the last picture must be that of the EXR file.
Needs the Python packages tevclient, numpy and OpenEXR.
"""

import os
import socket
import struct
import subprocess
import sys
import tempfile
import threading

import numpy
import OpenEXR
import tevclient


class Recorder:
    """A server that records the bytes of one connection."""

    def __init__(self):
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.data = bytearray()
        self.thread = threading.Thread(target=self.read)
        self.thread.start()

    def read(self):
        connection, _ = self.server.accept()
        with connection:
            while received := connection.recv(1 << 20):
                self.data += received

    def bytes(self):
        self.thread.join()
        self.server.close()
        return bytes(self.data)


class Fields:
    """The fields of a packet."""

    def __init__(self, packet):
        self.packet = packet
        self.place = 4

    def numbers(self, code, count=1):
        values = struct.unpack_from(f"<{count}{code}", self.packet, self.place)
        self.place += struct.calcsize(f"<{count}{code}")
        return values

    def text(self):
        end = self.packet.index(0, self.place)
        text = self.packet[self.place:end].decode()
        self.place = end + 1
        return text


def packets(stream):
    while stream:
        (length,) = struct.unpack_from("<I", stream)
        yield stream[:length]
        stream = stream[length:]


class Viewer:
    """An image that packets create and fill."""

    def apply(self, packet):
        """The name, channels and pixels of a picture that is complete, else None."""
        fields = Fields(packet)
        kind, focus = fields.numbers("B", 2)
        name = fields.text()
        if kind == 4:
            width, height, count = fields.numbers("i", 3)
            channels = [fields.text() for _ in range(count)]
            self.name, self.channels = name, channels
            self.pixels = numpy.zeros((height, width, count), "<f4")
            assert (focus, fields.place) == (1, len(packet))
            return None
        assert (kind, focus, name) == (6, 0, self.name)
        (count,) = fields.numbers("i")
        channels = [fields.text() for _ in range(count)]
        assert channels == self.channels
        x, y, width, height = fields.numbers("i", 4)
        offsets, strides = fields.numbers("q", count), fields.numbers("q", count)
        values = numpy.frombuffer(packet, "<f4", offset=fields.place)
        tile = numpy.arange(width * height)
        for c in range(count):
            plane = values[offsets[c] + strides[c] * tile].reshape(height, width)
            self.pixels[y:y + height, x:x + width, c] = plane
        is_last = (y + height, x + width) == self.pixels.shape[:2]
        return (self.name, self.channels, self.pixels.copy()) if is_last else None


def main():
    scene, *options = sys.argv[1:]
    program = os.environ.get("MANYLIGHT", "manylight")
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "image.exr")
        recorder = Recorder()
        preview = f"tev:127.0.0.1:{recorder.port}"
        subprocess.run([program, "render", scene, *options, "-o", image, "--preview", preview], check=True)
        stream = recorder.bytes()
        part = OpenEXR.File(image, separate_channels=True).channels()
        channels = {name: channel.pixels for name, channel in part.items()}

    viewer = Viewer()
    pictures = [picture for packet in packets(stream) if (picture := viewer.apply(packet))]
    _, names, pixels = pictures[-1]
    for c, name in enumerate(names):
        assert numpy.array_equal(pixels[..., c], channels[name]), f"{name} differs from the file"

    recorder = Recorder()
    with tevclient.Ipc("127.0.0.1", recorder.port) as client:
        created = None
        for name, names, pixels in pictures:
            if names != created:
                client.create_image(name, pixels.shape[1], pixels.shape[0], names)
                created = names
            client.update_image(name, pixels, names)
    assert recorder.bytes() == stream, "tevclient sends other bytes"
    print(f"{len(pictures)} pictures with {len(names)} channels, {len(stream)} bytes: equal to those of tevclient {tevclient.__version__}")


if __name__ == "__main__":
    main()
