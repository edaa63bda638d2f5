"""Certificates for tests of TLS, made by the openssl of the machine, and a broker's file of passwords."""

import subprocess
from pathlib import Path


def make_papers(folder: Path) -> Path:
    """An authority `ca`, certificates that it gave to `broker` and `fleet`, and an authority `other` that nobody knows.

    Each is NAME.pem with NAME.key, good for 127.0.0.1.
    """
    for authority in ("ca", "other"):
        key, paper = _files(folder, authority)
        _openssl(
            *("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={authority}"),
            *("-keyout", key, "-out", paper),
        )
    ca_key, ca = _files(folder, "ca")
    (folder / "names").write_text("subjectAltName=IP:127.0.0.1\n")
    for name in ("broker", "fleet"):
        key, paper = _files(folder, name)
        request = str(folder / f"{name}.csr")
        subject = ("-nodes", "-subj", f"/CN={name}")
        _openssl("req", "-newkey", "rsa:2048", *subject, "-keyout", key, "-out", request)
        signed = (
            "x509",
            "-req",
            "-in",
            request,
            "-CA",
            ca,
            "-CAkey",
            ca_key,
            "-CAcreateserial",
            "-days",
            "2",
        )
        _openssl(*signed, "-extfile", str(folder / "names"), "-out", paper)
    return folder


def passwords(file: Path, **users: str) -> Path:
    """A file that lets these users into a Mosquitto, each with a password."""
    file.write_text("".join(f"{user}:{password}\n" for user, password in users.items()))
    subprocess.run(["mosquitto_passwd", "-U", str(file)], check=True)
    return file


def _files(folder: Path, name: str) -> tuple[str, str]:
    return str(folder / f"{name}.key"), str(folder / f"{name}.pem")


def _openssl(*arguments: str) -> None:
    subprocess.run(["openssl", *arguments], check=True, capture_output=True)
