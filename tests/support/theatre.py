"""An application with a media session, and a publisher that plays to it."""

from tests.support.streaming import settle
from tests.support.viewing import Application, FedPublisher, FedRendition, WirelessConnection


class Theatre(Application):
    """An application with a session, and a publisher that plays to it."""

    def __init__(self) -> None:
        super().__init__()
        self.publisher = FedPublisher()
        self._reports = 0

    @property
    def connections(self) -> list[WirelessConnection]:
        return WirelessConnection.made

    @property
    def video(self) -> FedRendition:
        return self.publisher.renditions("video/VP8")[0]

    def connect(self, stream_id: str = "v") -> None:
        self.session.connect(stream_id, "engine/Video", self.publisher, "video")

    async def up(self, number: int = 0) -> WirelessConnection:
        """Answer the newest offer and connect."""
        await self.answer()
        self.connections[number].become("connected")
        self.connections[number].answers_questions = True
        await settle()
        return self.connections[number]

    async def play(self, connection: WirelessConnection, seconds: float = 0.5) -> None:
        """Let frames flow over the first section for a while."""
        for number in range(round(seconds * 10)):
            await self.video.show(keyframe=number == 0)
            self._reports += 1
            connection.report(self._reports)
            await self.clock.advance(0.1)

    async def wait(self, seconds: float) -> None:
        await self.clock.advance(seconds)
        await settle()
