"""The viewer's page for browsers, served on this machine, and kept from asking anybody else for anything."""

from __future__ import annotations

import re
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from humanoid_bt.core.errors import UserError
from humanoid_bt.record.sinks import LOOPBACK
from humanoid_bt.record.viewers import page_files

_LINK = re.compile(rb"<link[^>]*https?://[^>]*>")
_POLL = 0.05  # s that the end waits at most


class WebPage:
    """Serves the page as long as this process lives, or until it is closed.

    The viewer's own page sends the browser elsewhere for fonts, and what runs inside of it reports to its makers. This
    one has no links to other places, and a policy that forbids to talk to them: only to this page and the run's data.

    Args:
        port: of the page.
        data_port: where the page finds the run's data.

    Raises:
        UserError: the viewer's program does not start, or the port cannot be used.
    """

    def __init__(self, port: int, data_port: int) -> None:
        files = {path: (kind, _LINK.sub(b"", content)) for path, (kind, content) in page_files().items()}
        policy = _policy(data_port)

        class Answer(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self) -> None:
                kind, content = files.get(self.path.partition("?")[0], ("text/plain", b""))
                self.send_response(200 if content else 404)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(content)))
                self.send_header("Content-Security-Policy", policy)
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *_: object) -> None:
                pass

        try:
            self._server = ThreadingHTTPServer((LOOPBACK, port), Answer)
        except OSError as error:
            raise UserError(f"port {port} of {LOOPBACK} cannot be used: {error.strerror}") from error
        threading.Thread(target=self._server.serve_forever, args=(_POLL,), name="page", daemon=True).start()

    def close(self) -> None:
        """Serve it no more."""
        self._server.shutdown()
        self._server.server_close()


def _policy(data_port: int) -> str:
    """Return what the page may load and whom it may talk to, as browsers read it."""
    rules = {
        "default-src": "'self'",
        "script-src": "'self' 'unsafe-inline' 'wasm-unsafe-eval'",
        "style-src": "'self' 'unsafe-inline'",
        "img-src": "'self' data: blob:",
        "worker-src": "'self' blob:",
        "connect-src": f"'self' data: blob: http://{LOOPBACK}:{data_port}",
    }
    return "; ".join(f"{rule} {sources}" for rule, sources in rules.items())
