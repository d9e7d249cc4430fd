"""The Python client SDK: what an application needs of RoIS 2.0, asynchronous, typed, and connected again by itself.

```python
from openrois.client import Client
from openrois.client.components import Navigation

async with Client("ws://127.0.0.1:8765/") as client, client.body(Navigation) as body:
    await body[Navigation].set(target_positions=["lobby"])
    await body[Navigation].start()
```
"""

from openrois.client.body import Body
from openrois.client.body_directory import BodyComponent, BodyInfo
from openrois.client.client import Client
from openrois.client.commands import Command, Execution
from openrois.client.component import ComponentProxy
from openrois.client.connection import ConnectionState
from openrois.client.control import Control
from openrois.client.dialling import Dial
from openrois.client.errors import ConnectionFailed, ConnectionLost
from openrois.client.feed import Feed
from openrois.client.notices import (
    BindingLent,
    BindingLost,
    BindingRestored,
    BodyLost,
    Connected,
    ControlChanged,
    ControlDeclined,
    ControlRequested,
    ControlStopped,
    ControlWithdrawn,
    Disconnected,
    Fault,
    Notice,
    Notification,
    ProfileChanged,
    SubscriptionLost,
    SubscriptionRestored,
)
from openrois.client.reconnect import Reconnect
from openrois.client.steps import Concurrent, Step, concurrent
from openrois.client.subscription import Event, Subscription
from openrois.client.values import where
from openrois.errors import (
    Aborted,
    BadParameter,
    ComponentFailed,
    OutOfResources,
    RoISError,
    TimedOut,
    Unsupported,
)
from openrois.jsonrpc.session import RpcError

__all__ = [
    "Aborted",
    "BadParameter",
    "BindingLent",
    "BindingLost",
    "BindingRestored",
    "Body",
    "BodyComponent",
    "BodyInfo",
    "BodyLost",
    "Client",
    "Command",
    "ComponentFailed",
    "ComponentProxy",
    "Concurrent",
    "Connected",
    "ConnectionFailed",
    "ConnectionLost",
    "ConnectionState",
    "Control",
    "ControlChanged",
    "ControlDeclined",
    "ControlRequested",
    "ControlStopped",
    "ControlWithdrawn",
    "Dial",
    "Disconnected",
    "Event",
    "Execution",
    "Fault",
    "Feed",
    "Notice",
    "Notification",
    "OutOfResources",
    "ProfileChanged",
    "Reconnect",
    "RoISError",
    "RpcError",
    "Step",
    "Subscription",
    "SubscriptionLost",
    "SubscriptionRestored",
    "TimedOut",
    "Unsupported",
    "concurrent",
    "where",
]
