"""NATS and PostgreSQL of a gateway of a cluster, put together from the settings; they need the extra `cluster`."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

from openrois.auth.ranks import Ranks
from openrois.cluster.link import NatsLink, NatsSettings
from openrois.cluster.postgres.database import Database
from openrois.cluster.postgres.journal import PostgresJournal
from openrois.cluster.postgres.ownership import PostgresStore
from openrois.cluster.postgres.resumption import PostgresResumeStore
from openrois.cluster.postgres.schema import migrate_back
from openrois.cluster.postgres.stops import Stops
from openrois.cluster.presence import RANKS
from openrois.gateway.clustering import ClusterParts
from openrois.gateway.settings import GatewaySettings
from openrois.leases.epochs import ClaimedEpochs
from openrois.ownership.directorate import Directorate

__all__ = ["migrate_store_back", "open_parts"]


@asynccontextmanager
async def open_parts(settings: GatewaySettings) -> AsyncIterator[ClusterParts]:
    """Connect a gateway to what its cluster shares while the block runs.

    Raises:
        StoreUnreachable: PostgreSQL is not there.
        StoreUnusable: its schema is newer than this program can read.
        ValueError: an address or a file cannot be used.
    """
    nats = NatsSettings(
        settings.cluster,
        settings.cluster_credentials,
        settings.cluster_ca,
        settings.cluster_cert,
        settings.cluster_key,
        settings.cluster_name,
    )
    async with AsyncExitStack() as stack:
        database = Database(settings.store, settings.store_password, gateway_id=settings.gateway_id)
        await stack.enter_async_context(database)
        store = PostgresStore(database)
        directorate = await stack.enter_async_context(Directorate(store, settings.gateway_id))
        journal = PostgresJournal(database, settings.gateway_id, directorate.run, lambda: directorate.access.contact)
        await stack.enter_async_context(journal)
        stops = await stack.enter_async_context(Stops(database, settings.gateway_id))
        ranks = ",".join(Ranks.parse(settings.ranks).names)
        link = NatsLink(nats, settings.gateway_id, attributes={RANKS: ranks})
        epochs = ClaimedEpochs(lambda: directorate.problem)
        yield ClusterParts(link, directorate, journal, PostgresResumeStore(database), stops, epochs)


async def migrate_store_back(settings: GatewaySettings) -> int:
    """Carry what the gateways of a cluster share back by one version of the schema; return the version that it had.

    Raises:
        StoreUnreachable: PostgreSQL is not there, or refuses.
        StoreUnusable: the schema has not the version of this program.
        ValueError: an address or a file cannot be used.
    """
    database = Database(settings.store, settings.store_password, gateway_id=settings.gateway_id)
    async with database.connection() as connection:
        try:
            return await migrate_back(connection)
        finally:
            await connection.close(timeout=1.0)
