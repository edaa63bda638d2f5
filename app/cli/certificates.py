"""Client certificates for robots, of an authority of our own, made by the machine's `openssl`.

The broker is given `ca.pem`; a certificate's common name is the robot's user there (`use_identity_as_username`).
"""

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from app.domain.errors import Invalid

AUTHORITY = "ca"
AUTHORITY_DAYS = 3650
CLIENT = "keyUsage=critical,digitalSignature\nextendedKeyUsage=clientAuth\n"
"""Extensions of a robot's certificate: it authenticates a client, and signs no other."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """A certificate with its key, and that of the authority; PEM files."""

    certificate: Path
    key: Path
    authority: Path


class Authority:
    """Issues certificates; its own key is in the folder, readable by its owner only."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def of(self, name: str) -> Certificate:
        """Where the files of a robot are, or would be."""
        folder = self._folder / "certificates"
        return Certificate(
            certificate=folder / f"{name}.pem",
            key=folder / f"{name}.key",
            authority=self._folder / f"{AUTHORITY}.pem",
        )

    def issue(self, name: str, *, days: int, renew: bool = False) -> Certificate | None:
        """A certificate for the robot; None if it has one.

        :raises Invalid: if `openssl` is not installed, or fails.
        """
        made = self.of(name)
        if made.certificate.exists() and made.key.exists() and not renew:
            return None
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        made.certificate.parent.mkdir(exist_ok=True, mode=0o700)
        if not made.authority.exists():
            self._found()
        request = made.certificate.with_suffix(".csr")
        extensions = made.certificate.with_suffix(".ext")
        issued = made.certificate.with_suffix(".new")
        key = made.key.with_suffix(".newkey")
        extensions.write_text(CLIENT, encoding="utf-8")
        try:
            _openssl(
                "req", "-new", *_NEW_KEY, "-subj", f"/CN={name}", "-keyout", str(key), "-out", str(request)
            )
            authority = ("-CA", str(made.authority), "-CAkey", str(self._folder / f"{AUTHORITY}.key"))
            _openssl(
                *("x509", "-req", "-in", str(request), *authority, "-CAcreateserial", "-days", str(days)),
                *("-extfile", str(extensions), "-out", str(issued)),
            )
            key.replace(made.key)
            issued.replace(made.certificate)
        finally:
            for leftover in (request, extensions, issued, key):
                leftover.unlink(missing_ok=True)
        return made

    def forget(self, name: str) -> bool:
        """Delete the files of a robot; True if there were some."""
        files = [file for file in (self.of(name).certificate, self.of(name).key) if file.exists()]
        for file in files:
            file.unlink()
        return bool(files)

    def _found(self) -> None:
        """Make the authority."""
        key = self._folder / f"{AUTHORITY}.key"
        made = self._folder / f"{AUTHORITY}.new"
        _openssl(
            *("req", "-x509", "-new", *_NEW_KEY, "-days", str(AUTHORITY_DAYS), "-subj", "/CN=Macta robots"),
            *("-keyout", str(key), "-out", str(made)),
        )
        made.chmod(0o644)
        made.replace(self._folder / f"{AUTHORITY}.pem")


_NEW_KEY = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes")


def _openssl(*arguments: str) -> None:
    program = shutil.which("openssl")
    if program is None:
        raise Invalid("--certificate needs the program openssl: apt-get install openssl", code="no-openssl")
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False, umask=0o077)
    if done.returncode != 0:
        words = done.stderr.strip().splitlines() or ["no reason given"]
        raise Invalid(f"openssl {arguments[0]} failed: {words[-1]}", code="openssl-failed")
