"""bench_line - between `kelly bench` and an emulated board: a line on which something is done to what the board says.

    with Between("rv32", liar) as line:
        kelly("bench", "--port", line.port, ...)

`change(message, line)` gets each frame of the board, (name, seq, fields), and returns the bytes that go on in its place; what is
no frame goes on as it is. Ports: unix: (the default), tcp:, or a pseudo terminal.
"""
import os
import selectors
import socket
import subprocess
import tempfile
import threading
import time
import tty

from bench_board import image, link
from run_target import command, target_settings


class Between:
    def __init__(self, target, change=None, kind="unix", icount=None):
        self.change, self.receiver, self.frames, self.heard = change, link.Receiver(), 0, bytearray()
        self.folder = tempfile.TemporaryDirectory()
        self.kind, self.end, self.listener = kind, None, None
        self.port = self._open()
        near, far = socket.socketpair()
        self.board = subprocess.Popen(command(target_settings(target), image(target), icount), stdin=far, stdout=far, stderr=subprocess.DEVNULL)
        far.close()
        self.near, self.running, self.asked = near, True, None
        self.thread = threading.Thread(target=self._run)

    def _open(self):
        if self.kind == "pty":
            self.end, self.slave = os.openpty()
            tty.setraw(self.slave)
            return os.ttyname(self.slave)
        self.listener = socket.socket(socket.AF_INET if self.kind == "tcp" else socket.AF_UNIX)
        self.listener.bind(("127.0.0.1", 0) if self.kind == "tcp" else os.path.join(self.folder.name, "line"))
        self.listener.listen(4)
        return f"tcp:127.0.0.1:{self.listener.getsockname()[1]}" if self.kind == "tcp" else "unix:" + self.listener.getsockname()

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.running = False
        self.thread.join()
        self.board.kill()
        self.board.wait()
        self.near.close()
        self._pull(False)
        self.folder.cleanup()

    def pull(self, for_good=True):
        """The cable: the host's end closes, and with `for_good` nobody is there any more. Done by the thread that serves it."""
        self.asked = for_good
        while self.asked is not None and self.thread.is_alive():
            time.sleep(0.005)

    def _pull(self, for_good):
        if isinstance(self.end, socket.socket):
            self.end.close()
        elif self.end is not None:
            os.close(self.end)
            os.close(self.slave)
        self.end = None
        if for_good and self.listener:
            self.listener.close()
            self.listener = None

    # ---- bytes

    def _run(self):
        while self.running:
            if self.asked is not None:
                self._pull(self.asked)
                self.asked = None
            with selectors.DefaultSelector() as wait:
                for end in (self.near, self.listener, self.end):
                    if end is not None:
                        wait.register(end, selectors.EVENT_READ)
                for key, _ in wait.select(0.05):
                    self._serve(key.fileobj)

    def _serve(self, end):
        try:
            if end is self.listener and end is not None:
                self._pull(False)
                self.end, _ = self.listener.accept()
            elif end is self.near:
                self._up(self.near.recv(4096))
            elif end is self.end and end is not None:
                data = os.read(end if isinstance(end, int) else end.fileno(), 4096)
                if data:
                    self.near.sendall(data)
                else:
                    self._pull(False)
        except OSError:
            pass

    def _up(self, data):
        out = data
        if self.change:
            out = b"".join(self.change(message, self) for message in self.receiver.feed(data))
        if self.end is not None and out:
            os.write(self.end, out) if isinstance(self.end, int) else self.end.sendall(out)


def again(message):
    """The frame of a message."""
    name, seq, fields = message
    return link.frame(name, seq, **fields) if name else link.raw_frame(fields["type"], seq, fields["body"])
