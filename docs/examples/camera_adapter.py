"""A camera with a zoom behind a gateway: run it, and Ctrl-C ends it. CAMERA is its number, a path or a URL."""

import os
from collections.abc import Iterator
from typing import Annotated, Any

import cv2
from openrois_media import VideoSource, main
from pydantic import Field

from openrois.adapter import Component, parameter

SIZE = (640, 480)


class Lens(Component, authority="Example", function="actuation"):
    """The zoom of a camera."""

    zoom: Annotated[float, Field(ge=1, le=8)] = parameter(1.0, description="how many times larger things are shown")

    def pictures(self, camera: str) -> Iterator[Any]:
        """Read the camera, in a thread of its own, while an application watches."""
        capture = cv2.VideoCapture(int(camera) if camera.isdigit() else camera)
        try:
            while True:
                is_there, picture = capture.read()
                if not is_there:
                    raise RuntimeError(f"the camera {camera} gives no picture: is it connected, and used by no other?")
                height, width = picture.shape[:2]
                top, left = (round(side * (1 - 1 / self.zoom) / 2) for side in (height, width))
                yield cv2.resize(picture[top : height - top, left : width - left], SIZE)
        finally:
            capture.release()


if __name__ == "__main__":
    lens = Lens("lens")
    camera = os.environ.get("CAMERA", "0")
    main(lens, engine_id="camera_1", streams={"camera": VideoSource(lambda: lens.pictures(camera), size=SIZE)})
