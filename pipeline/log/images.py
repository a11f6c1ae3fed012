"""Images in a log: each image output is a channel of foxglove.CompressedImage messages, PNG, which loses nothing."""

from __future__ import annotations

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from google.protobuf.message import DecodeError
from google.protobuf.timestamp_pb2 import Timestamp

from components.contract import ImagePort

SECOND_NS = 1_000_000_000


def topic(component: str, port: str) -> str:
    """Where an image output is recorded."""
    return f"/image/{component}.{port}"


def message(frame: str, t_ns: int, image: np.ndarray) -> bytes:
    """An image (height, width) or (height, width, 3) RGB, uint8, as the log keeps it. frame: that of the camera."""
    seconds, nanos = divmod(t_ns, SECOND_NS)
    stamp = Timestamp(seconds=seconds, nanos=nanos)
    return CompressedImage(timestamp=stamp, frame_id=frame, data=_png(image), format="png").SerializeToString()


def pixels(port: ImagePort, payload: bytes) -> np.ndarray:
    """The image in a message, of the port's shape. Raises ValueError if it is another or none."""
    import cv2

    try:
        data = CompressedImage.FromString(payload).data
    except DecodeError as error:
        raise ValueError(f"an image's message is damaged ({error})") from error
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if image is None or image.dtype != np.uint8 or image.shape != port.shape:
        told = "none" if image is None else f"{image.dtype} of {image.shape}"
        raise ValueError(f"the PNG is {told} where an image of {port.shape} is expected")
    return np.ascontiguousarray(image[:, :, ::-1]) if image.ndim == 3 else image


def _png(image: np.ndarray) -> bytes:
    """Chosen by speed: 12 ms for a noisy grey megapixel, and smaller than by OpenCV's own choice, which takes 24 ms."""
    import cv2  # takes 0.1 s to import, which a log without images does without

    how = {
        cv2.IMWRITE_PNG_FILTER: cv2.IMWRITE_PNG_FILTER_AVG,
        cv2.IMWRITE_PNG_STRATEGY: cv2.IMWRITE_PNG_STRATEGY_RLE,
        cv2.IMWRITE_PNG_COMPRESSION: 1,
    }
    is_color = image.ndim == 3
    given = np.ascontiguousarray(image[:, :, ::-1]) if is_color else image  # OpenCV takes blue first
    return cv2.imencode(".png", given, [number for pair in how.items() for number in pair])[1].tobytes()
