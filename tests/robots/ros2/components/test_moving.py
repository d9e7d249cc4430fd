"""Navigation, Move and Follow of a robot that speaks ROS 2."""

from math import dist, pi

import pytest

from openrois.client.components import Follow, Move, Navigation
from openrois.errors import Aborted, ComponentFailed, RoISError, TimedOut
from tests.support.ros_robot import MAPPING, message, staged

pytestmark = pytest.mark.extra(name="ros2")


async def test_a_route_is_driven_target_by_target() -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0", "table", "2,2,-1.5"])
            going = await stage.begun(stage.client.run(navigation.start()))
            graph = stage.graph
            assert len(graph.goals) == 1
            assert graph.goals[0].goal["pose"]["header"]["frame_id"] == "map"
            assert graph.goals[0].goal["pose"]["header"]["stamp"]["sec"] > 1_700_000_000
            assert graph.goals[0].place == pytest.approx((1, 0, 0), abs=1e-6)
            limit = next(what for name, what in graph.published if name == "/speed_limit")
            assert limit == {"percentage": False, "speed_limit": 0.5}
            graph.goals[0].end("succeeded")
            await stage.run(0.1)
            assert graph.goals[1].place == pytest.approx((1, 2, 1.5))
            assert not going.done()
            graph.goals[1].end("succeeded")
            await stage.run(0.1)
            assert graph.goals[2].place == pytest.approx((2, 2, -1.5))
            graph.goals[2].end("succeeded")
            await stage.until(going, 1.0)
            assert [each.canceled for each in graph.goals] == [0, 0, 0]


@pytest.mark.parametrize(
    ("target", "said"),
    [
        ("garden", "'garden' is neither a position x,y or x,y,th nor a place; the places are 'dock', 'table'"),
        ("1,2,3,4", "is neither a position"),
        ("nan,1", "is neither a position"),
        ("99999,1", "is neither a position"),
    ],
)
async def test_targets_that_are_none_are_refused_at_once(target: str, said: str) -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            with pytest.raises(ComponentFailed, match=said):
                await navigation.set(target_positions=[target])
            with pytest.raises(ComponentFailed, match="expected 1 to 100 positions"):
                await navigation.set(target_positions=[])


@pytest.mark.parametrize(
    ("outcome", "result", "error", "said"),
    [
        ("aborted", {"error_code": 3, "error_msg": "no way"}, ComponentFailed, "could not get there: no way"),
        ("aborted", {"error_code": 3, "error_msg": ""}, ComponentFailed, "could not get there: error code 3"),
        ("aborted", {"result": {}}, ComponentFailed, "could not get there: the goal was aborted"),
        ("unknown", {}, ComponentFailed, "could not get there: the goal was unknown"),
        ("canceled", {}, Aborted, "the goal was cancelled, by a stop or by another node"),
    ],
)
async def test_the_end_of_a_goal_is_the_end_of_the_command(
    outcome: str, result: dict[str, object], error: type[RoISError], said: str
) -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0"])
            going = await stage.begun(stage.client.run(navigation.start()))
            stage.graph.goals[0].end(outcome, **result)
            with pytest.raises(error, match=said):
                await stage.until(going, 1.0)


async def test_a_rejected_goal_is_said() -> None:
    async with staged() as stage:
        stage.graph.rejects = True
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0"])
            with pytest.raises(ComponentFailed, match="the action has rejected the goal"):
                await stage.until(stage.client.run(navigation.start()), 1.0)


async def test_a_stop_cancels_the_goal() -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0"])
            going = await stage.begun(stage.client.run(navigation.start()))
            await stage.until(stage.client.run(navigation.stop()), 1.0)
            assert stage.graph.goals[0].canceled == 1
            with pytest.raises(Aborted):
                await stage.until(going, 1.0)


async def test_a_robot_that_does_not_confirm_the_cancellation_is_told_to_stand_and_it_is_said() -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0"])
            going = await stage.begun(stage.client.run(navigation.start()))
            stage.graph.goals[0].confirms = False
            with pytest.raises(ComponentFailed, match=r"the action has not answered within 0\.4 s"):
                await stage.until(stage.client.run(navigation.stop()), 1.0)
            assert not going.done()
            stage.graph.goals[0].confirms = True
            await stage.until(stage.client.run(navigation.stop()), 1.0)
            with pytest.raises(Aborted):
                await stage.until(going, 1.0)


async def test_a_goal_that_could_not_be_cancelled_is_cancelled_as_soon_as_it_can_be() -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0"])
            going = await stage.begun(stage.client.run(navigation.start()))
            goal = stage.graph.goals[0]
            goal.confirms = stage.is_alive = False
            with pytest.raises(ComponentFailed, match="nothing has come on /odom"):
                await stage.until(going, 3.0)
            await stage.run(1.0)
            tried = goal.canceled
            assert tried > 2
            goal.confirms = stage.is_alive = True
            await stage.run(1.0)
            assert goal.ending.done()
            await stage.run(5.0)
            assert goal.canceled == tried + 1


async def test_a_suspended_navigation_sends_its_goal_again() -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0"])
            going = await stage.begun(stage.client.run(navigation.start()))
            await stage.until(stage.client.run(navigation.suspend()), 1.0)
            await stage.run(1.0)
            assert stage.graph.goals[0].canceled == 1
            assert len(stage.graph.goals) == 1
            await stage.until(stage.client.run(navigation.resume()), 1.0)
            await stage.run(0.1)
            assert len(stage.graph.goals) == 2
            stage.graph.goals[1].end("succeeded")
            await stage.until(going, 1.0)


async def test_a_time_limit_ends_it_and_cancels_the_goal() -> None:
    async with staged() as stage:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["1,0"], time_limit=2000)
            with pytest.raises(TimedOut, match="took longer than 2000 ms"):
                await stage.until(stage.client.run(navigation.start()), 3.0)
        assert stage.graph.goals[0].canceled == 1


async def test_another_motion_takes_the_robot_over() -> None:
    async with staged() as stage:
        navigation, move = await stage.client.find(Navigation), await stage.client.find(Move)
        async with navigation.bound(), move.bound():
            await navigation.set(target_positions=["1,0"])
            going = await stage.begun(stage.client.run(navigation.start()))
            await move.set(line=[200, 0])
            await stage.until(stage.client.run(move.start()), 5.0)
            with pytest.raises(Aborted, match="move has the body now"):
                await stage.until(going, 1.0)
        assert stage.graph.goals[0].canceled == 1


@pytest.mark.parametrize(
    ("line", "place"),
    [
        ([500, 0], (0.5, 0.0, 0.0)),
        ([-300, 0], (-0.3, 0.0, 0.0)),
        ([400, 90], (0.4, 0.0, pi / 2)),
        ([0, -180], (0, 0, -pi)),
    ],
)
async def test_move_goes_a_line(line: list[int], place: tuple[float, float, float]) -> None:
    async with staged() as stage:
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(line=line)
            await stage.until(stage.client.run(move.start()))
        assert dist(stage.place[:2], place[:2]) < 0.05
        assert stage.place[2] == pytest.approx(place[2], abs=0.1)
        await stage.run(1.0)
        velocities = stage.graph.velocities()
        assert velocities[-1] == (0.0, 0.0)
        assert max(abs(ahead) for ahead, _ in velocities) <= 0.5
        assert max(abs(turn) for _, turn in velocities) <= 1.0


async def test_move_goes_a_curve() -> None:
    async with staged() as stage:
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(curve=[1000, 90])
            await stage.until(stage.client.run(move.start()))
        assert dist(stage.place[:2], (1.0, 1.0)) < 0.15
        assert stage.place[2] == pytest.approx(pi / 2, abs=0.1)


async def test_move_takes_the_time_that_it_is_given() -> None:
    async with staged() as stage:
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(line=[500, 0], time=5000)
            await stage.until(stage.client.run(move.start()))
            assert max(ahead for ahead, _ in stage.graph.velocities()) == pytest.approx(0.1)
            with pytest.raises(ComponentFailed, match=r"the speed must be between 0.01 and 0.5 m/s"):
                await move.set(line=[5000, 0], time=1000)


async def test_a_robot_that_does_not_get_on_is_stuck() -> None:
    async with staged() as stage:
        stage.obeys = False
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(line=[500, 0])
            with pytest.raises(ComponentFailed, match=r"has not come nearer to the end for 4 s, and 0.50 m or rad"):
                await stage.until(stage.client.run(move.start()), 10.0)
        assert stage.graph.velocities()[-1] == (0.0, 0.0)


async def test_a_suspended_move_stands_and_goes_on_where_it_was() -> None:
    async with staged() as stage:
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(line=[1000, 0])
            going = await stage.begun(stage.client.run(move.start()), 1.0)
            await stage.until(stage.client.run(move.suspend()), 1.0)
            await stage.run(0.5)
            stood = list(stage.place)
            assert stage.graph.velocities()[-1] == (0.0, 0.0)
            await stage.run(10.0)
            assert stage.place == stood
            await stage.until(stage.client.run(move.resume()), 1.0)
            await stage.until(going)
        assert stage.place[0] == pytest.approx(1.0, abs=0.05)


async def test_a_stop_says_zero_at_once_and_more_than_once() -> None:
    async with staged() as stage:
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(line=[5000, 0])
            going = await stage.begun(stage.client.run(move.start()), 1.0)
            before = len(stage.graph.velocities())
            await stage.until(stage.client.run(move.stop()), 1.0)
            await stage.run(1.0)
            with pytest.raises(Aborted):
                await going
        assert stage.graph.velocities()[before:] == [(0.0, 0.0)] * 3


async def test_a_velocity_that_cannot_be_published_ends_the_move() -> None:
    async with staged() as stage:
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(line=[5000, 0])
            going = await stage.begun(stage.client.run(move.start()), 0.5)
            stage.graph.problems["/cmd_vel"] = "no node subscribes to /cmd_vel"
            with pytest.raises(ComponentFailed, match="no node subscribes to /cmd_vel"):
                await stage.until(going, 1.0)


@pytest.mark.parametrize("stamped", [False, True])
async def test_the_velocity_is_of_the_type_that_the_mapping_says(stamped: bool) -> None:
    velocity = {"topic": "cmd_vel", **({"type": "geometry_msgs/msg/TwistStamped", "frame": "base"} if stamped else {})}
    async with staged({**MAPPING, "velocity": velocity}) as stage:
        move = await stage.client.find(Move)
        async with move.bound():
            await move.set(line=[200, 0])
            await stage.until(stage.client.run(move.start()))
        twist = next(what for name, what in stage.graph.published if name == "/cmd_vel")
        assert ("header" in twist) is stamped
        if stamped:
            assert twist["header"]["frame_id"] == "base"


def visitor(x: float, y: float, frame: str = "map") -> object:
    return message(
        header={"frame_id": frame, "stamp": {"sec": 0, "nanosec": 0}},
        pose={"position": {"x": x, "y": y, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
    )


async def test_follow_keeps_its_distance_and_sends_goals_as_the_target_moves() -> None:
    async with staged() as stage:
        follow = await stage.client.find(Follow)
        stage.graph.say("/visitor_pose", visitor(3.0, 0.0))
        async with follow.bound():
            await follow.set(target_object_ref="visitor", distance=1000)
            going = await stage.begun(stage.client.run(follow.start()), 0.5)
            assert [goal.place for goal in stage.graph.goals] == [pytest.approx((2.0, 0.0, 0.0))]
            # A step of the target is worth no goal, and another one comes after a second at the earliest.
            stage.graph.say("/visitor_pose", visitor(3.1, 0.0))
            await stage.run(1.5)
            assert len(stage.graph.goals) == 1
            stage.graph.say("/visitor_pose", visitor(3.0, 3.0))
            await stage.run(1.5)
            assert len(stage.graph.goals) == 2
            # The navigation of ROS ends the goal that was replaced.
            stage.graph.goals[0].end("aborted")
            stage.graph.say("/visitor_pose", visitor(0.5, 0.0))
            await stage.run(0.5)
            assert stage.graph.goals[1].canceled == 1
            await stage.until(stage.client.run(follow.stop()), 1.0)
            with pytest.raises(Aborted):
                await going


async def test_a_target_that_is_gone_for_long_ends_it() -> None:
    async with staged() as stage:
        follow = await stage.client.find(Follow)
        stage.graph.say("/visitor_pose", visitor(3.0, 0.0))
        async with follow.bound():
            await follow.set(target_object_ref="visitor", distance=1000)
            with pytest.raises(ComponentFailed, match="'visitor' has not been seen for 5 s"):
                await stage.until(stage.client.run(follow.start()), 10.0)
        assert stage.graph.goals[0].canceled == 1


async def test_a_robot_that_cannot_follow_is_said_after_some_tries() -> None:
    async with staged() as stage:
        follow = await stage.client.find(Follow)
        async with follow.bound():
            await follow.set(target_object_ref="visitor", distance=1000)
            stage.graph.say("/visitor_pose", visitor(3.0, 0.0))
            going = await stage.begun(stage.client.run(follow.start()))
            for _ in range(30):
                stage.graph.say("/visitor_pose", visitor(3.0, 0.0))
                stage.graph.goals[-1].end("aborted", error_code=7, error_msg="no way")
                await stage.run(0.2)
                if going.done():
                    break
            with pytest.raises(ComponentFailed, match="could not follow, 3 times: no way"):
                await going


async def test_a_goal_does_not_run_on_where_the_next_one_is_not_accepted() -> None:
    async with staged() as stage:
        follow = await stage.client.find(Follow)
        stage.graph.say("/visitor_pose", visitor(3.0, 0.0))
        async with follow.bound():
            await follow.set(target_object_ref="visitor", distance=1000)
            going = await stage.begun(stage.client.run(follow.start()), 1.5)
            assert len(stage.graph.goals) == 1
            stage.graph.rejects = True
            stage.graph.say("/visitor_pose", visitor(3.0, 3.0))
            with pytest.raises(ComponentFailed, match="the action has rejected the goal"):
                await stage.until(going, 2.0)
        assert stage.graph.goals[0].canceled == 1


@pytest.mark.parametrize("frame", ["odom", ""])
async def test_frames_that_differ_are_said(frame: str) -> None:
    async with staged() as stage:
        follow = await stage.client.find(Follow)
        stage.graph.say("/visitor_pose", visitor(3.0, 0.0, frame))
        async with follow.bound():
            await follow.set(target_object_ref="visitor", distance=1000)
            with pytest.raises(ComponentFailed, match=f"the target is in the frame '{frame}', the robot in 'map'"):
                await stage.until(stage.client.run(follow.start()), 2.0)


async def test_what_cannot_be_followed_is_refused() -> None:
    async with staged() as stage:
        follow = await stage.client.find(Follow)
        async with follow.bound():
            with pytest.raises(ComponentFailed, match="'dog' cannot be followed; there is 'visitor'"):
                await follow.set(target_object_ref="dog")
            with pytest.raises(ComponentFailed, match="set target_object_ref and distance first"):
                await stage.client.run(follow.start())
