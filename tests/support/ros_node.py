"""A node that other nodes are tried with: `python -m tests.support.ros_node DOMAIN [best_effort]`.

It sends back what it hears, answers a service, and does what goals ask for in their `behavior_tree`. It says in lines
what has happened to goals.
"""

import asyncio
import sys
from collections.abc import AsyncGenerator, Mapping
from typing import Any

from openrois_robots.ros2.cyclone.participant import Participant
from openrois_robots.ros2.cyclone.servers import Aborted, DdsActionServer, DdsServiceServer
from openrois_robots.ros2.cyclone.topics import DdsPublisher, DdsSubscription
from openrois_robots.ros2.cyclone.types import TypeMaker
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.interfaces.store import Interfaces

from openrois.aio.tasks import TaskScope
from tests.support.ros_graph import INTERFACES

STRING = "std_msgs/msg/String"
GO = "nav2_msgs/action/NavigateToPose"


def say(line: str) -> None:
    print(line, flush=True)


class Acts:
    """Executes goals."""

    def accepts(self, goal: Any) -> bool:
        return bool(goal.behavior_tree != "reject")

    async def execute(self, goal: Any) -> AsyncGenerator[Mapping[str, Any], None]:
        say(f"begun {goal.behavior_tree}")
        try:
            for left in (2.0, 1.0):
                yield {"distance_remaining": left, "current_pose": {"header": {"frame_id": "map"}}}
            if goal.behavior_tree == "abort":
                raise Aborted({"error_code": 9, "error_msg": "a wall"})
            if goal.behavior_tree == "hold":
                await asyncio.Event().wait()
        except (asyncio.CancelledError, GeneratorExit):
            say("canceled")
            raise


async def main(domain: int, reliability: str) -> None:
    types = TypeMaker(Interfaces(folder=INTERFACES))
    async with Participant(domain) as participant, TaskScope() as tasks:
        qos = Qos("best_effort" if reliability == "best_effort" else "reliable", "volatile", 100)
        back = DdsPublisher(participant, types, "/back", STRING, qos)
        DdsSubscription(
            participant, types, "/there", STRING, Qos(), lambda message: back.publish({"data": message.data})
        )
        kept = DdsPublisher(participant, types, "/kept", STRING, Qos("reliable", "transient_local", 1))
        kept.publish({"data": "from before"})

        async def switch(request: Any) -> Mapping[str, Any]:
            if not request.data:
                await asyncio.Event().wait()
            return {"success": True, "message": "on"}

        service = types.interfaces.service("std_srvs/srv/SetBool")
        DdsServiceServer(participant, types, "/switch", service, switch, tasks)
        DdsActionServer(participant, types, "/go", GO, Acts(), tasks)
        # What it has of another type, and of another definition of the same type.
        DdsPublisher(participant, types, "/odd", "geometry_msgs/msg/Twist", Qos())
        DdsActionServer(participant, TypeMaker(Interfaces("humble")), "/old", GO, Acts(), tasks)
        say("ready")
        await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(main(int(sys.argv[1]), (*sys.argv[2:], "reliable")[0]))
