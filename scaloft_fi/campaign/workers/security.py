"""The certificates with which a Dask cluster encrypts, and by which its parts know each other."""

from __future__ import annotations

import ssl
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.errors import InputError

if TYPE_CHECKING:
    from distributed import Security

FILES = ("ca.pem", "cert.pem", "key.pem")
"""The files of the folder: the certificate of the authority, our own certificate, our own private key."""


def check_certificates(folder: Path) -> None:
    """Check early that the files of `folder` are certificates and a key that fit.

    Raises:
        InputError: a file is missing or no certificate.
    """
    for name in FILES:
        if not (folder / name).is_file():
            raise InputError(f"--cluster-security={folder}: {folder / name} is missing; needed: {', '.join(FILES)}")
    authority, certificate, key = (str(folder / name) for name in FILES)
    try:
        context = ssl.create_default_context(cafile=authority)
        context.load_cert_chain(certificate, key, password="")
    except (OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or error
        raise InputError(f"--cluster-security={folder}: {', '.join(FILES)} do not fit each other: {reason}") from error


def security_of(folder: Path | None) -> Security:
    """The security of a client with the certificates in `folder`; None = not encrypted."""
    from distributed import Security

    if folder is None:
        return Security()
    authority, certificate, key = (str(folder / name) for name in FILES)
    return Security(tls_ca_file=authority, tls_client_cert=certificate, tls_client_key=key, require_encryption=True)
