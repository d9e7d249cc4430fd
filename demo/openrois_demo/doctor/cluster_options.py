"""The doctor's options for what several gateways share: those of `openrois gateway`, by the same names."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from openrois_demo.doctor.cluster import Shared

__all__ = ["add_cluster_options", "shared_parts"]


def add_cluster_options(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    group = parser.add_argument_group("several gateways", "as `openrois gateway` takes them")
    group.add_argument("--gateway-id", default="", metavar="ID", help="the id that this machine's gateway is to have")
    group.add_argument("--cluster", action="append", default=[], metavar="URL", help="NATS, nats://HOST:PORT or tls://")
    group.add_argument("--cluster-name", default="openrois", metavar="NAME", help="the cluster's name (%(default)s)")
    group.add_argument("--cluster-credentials", type=Path, metavar="FILE", help="a token, or a user and a password")
    group.add_argument("--cluster-ca", type=Path, metavar="FILE", help="authorities that signed NATS's certificate")
    group.add_argument("--cluster-cert", type=Path, metavar="FILE", help="a certificate that NATS is shown")
    group.add_argument("--cluster-key", type=Path, metavar="FILE", help="its key")
    group.add_argument("--store", default="", metavar="URL", help="PostgreSQL, postgresql://USER@HOST/DATABASE")
    group.add_argument("--store-password", type=Path, metavar="FILE", help="its password")


def shared_parts(chosen: argparse.Namespace) -> "Shared":
    """Return what the options name.

    Raises:
        ValueError: one of them cannot be used; the message says why.
    """
    if not (chosen.cluster and chosen.store):
        raise ValueError("--cluster and --store must be given together: gateways share NATS and PostgreSQL")
    from openrois.cluster.postgres.database import Database
    from openrois.cluster.settings import NatsSettings
    from openrois_demo.doctor.cluster import Shared

    nats = NatsSettings(
        tuple(chosen.cluster),
        chosen.cluster_credentials,
        chosen.cluster_ca,
        chosen.cluster_cert,
        chosen.cluster_key,
        chosen.cluster_name,
    )
    nats.login()
    if nats.names_tls:
        nats.context()
    return Shared(nats, Database(chosen.store, chosen.store_password, gateway_id="doctor"), chosen.gateway_id)
