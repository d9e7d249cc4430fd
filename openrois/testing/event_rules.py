"""What a component owes to whoever listens to it."""

from openrois.testing.subject import Ears, Subject, require

__all__ = ["its_events_can_be_subscribed"]


async def its_events_can_be_subscribed(subject: Subject) -> None:
    """Every event of the profile can be subscribed, any number of times, and unsubscribed; once more is ignored."""
    for event in subject.profile.event_profiles:
        ids: list[str] = []
        for _ in range(2):
            doing = f"subscribe to {event.name}"
            subscribed = subject.bus.subscribe(subject.component_ref, event.name, Ears())
            ids.append(await subject.within(doing, subscribed))
        require(all(ids) and ids[0] != ids[1], f"two subscriptions to {event.name} have the ids {ids}")
        for subscribe_id in (*ids, *ids):
            await subject.within(f"unsubscribe from {event.name}", subject.bus.unsubscribe(subscribe_id))
