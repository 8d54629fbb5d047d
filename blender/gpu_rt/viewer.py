"""A viewer that the program sends its image to while it renders, by the protocol of tev (github.com/Tom94/tev)."""

import socket
import struct
import threading

import numpy as np

# Operations of packets.
CREATE, UPDATE = 4, 6


class Viewer:
    """Listens on a port of this machine. `take` has the newest whole image."""

    def __init__(self):
        self._server = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self._server.getsockname()[1]
        self._newest = None
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def take(self):
        """The newest image that has not been taken: height x width x 3, row 0 on top. None if there is none."""
        newest, self._newest = self._newest, None
        return newest

    def __enter__(self):
        return self

    def __exit__(self, *_):
        # Closing alone would not wake a thread that waits for the program.
        try:
            self._server.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._server.close()

    def _serve(self):
        while True:
            try:
                connection, _ = self._server.accept()
            except OSError:
                return  # this viewer is closed
            try:
                with connection, connection.makefile("rb") as stream:
                    self._read(stream)
            except (OSError, struct.error, ValueError):
                pass  # the render has ended

    def _read(self, stream):
        pixels = None
        while True:
            (length,) = struct.unpack("<I", stream.read(4))
            packet = stream.read(length - 4)
            operation, at = packet[0], packet.index(0, 2) + 1
            if operation == CREATE:
                width, height = struct.unpack_from("<ii", packet, at)
                pixels = np.zeros((height, width, 3), np.float32)
            elif operation == UPDATE:
                # Red, green and blue of a pixel stand together, which the strides say.
                (channels,) = struct.unpack_from("<i", packet, at)
                at += 4
                for _ in range(channels):
                    at = packet.index(0, at) + 1
                x, y, width, height = struct.unpack_from("<iiii", packet, at)
                band = np.frombuffer(packet, "<f4", width * height * channels, at + 16 + 16 * channels)
                pixels[y:y + height, x:x + width] = band.reshape(height, width, channels)
                if y + height == pixels.shape[0]:
                    self._newest = pixels.copy()
