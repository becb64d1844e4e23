"""The participant's end of a connection through shared memory (protocol/WIRE.md, "Shared memory")."""

from __future__ import annotations

import ctypes
import os
import time
from typing import Optional, Tuple

import iceoryx2 as iox2

from .wire import LAYOUT, Frame, Header

SAMPLE_DOUBLES = 1 << 14
WAITING_SAMPLES = 4
POLLING_S = 0.9e-3
POLLING_ON_SHARED_CORE_S = 20e-6
LATE_YIELD_S = 50e-6
SLICE_S = 20e-3
LOOKS = 20


class LinkError(Exception):
    """The coordinator has left, or the connection does not work."""


class LinkFull(LinkError):
    """The other end took no sample in time. The same frame can be sent again, and continues where it was cut off."""


class _Header(ctypes.Structure):
    _fields_ = [
        ("kind", ctypes.c_uint32), ("protocol", ctypes.c_uint32), ("run_id", ctypes.c_uint64),
        ("interface", ctypes.c_uint32), ("iteration", ctypes.c_uint32), ("window", ctypes.c_uint64),
        ("step", ctypes.c_uint64), ("substeps", ctypes.c_uint32), ("count", ctypes.c_uint32),
        ("t0_s", ctypes.c_double), ("t1_s", ctypes.c_double), ("checksum", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name() -> str:
        return "thirdbody.header.v1"


class Link:
    """Requests in, answers out; frames arrive in order, once and whole."""

    def __init__(self, root: str, prefix: str, participant: str, patience_s: float) -> None:
        """Opens the connection that the coordinator creates within `patience_s`."""
        iox2.set_log_level(iox2.LogLevel.Error)
        settings = iox2.config.default()
        settings.global_cfg.root_path = iox2.Path.new(root)
        settings.global_cfg.prefix = iox2.FileName.new(prefix)
        settings.global_cfg.service.event_connection_suffix = iox2.FileName.new(".ev")
        settings.global_cfg.service.cleanup_dead_nodes_on_open = False
        settings.global_cfg.node.cleanup_dead_nodes_on_creation = False
        settings.global_cfg.node.cleanup_dead_nodes_on_destruction = False
        self._node = (
            iox2.NodeBuilder.new()
            .config(settings)
            .signal_handling_mode(iox2.SignalHandlingMode.Disabled)
            .create(iox2.ServiceType.Ipc)
        )
        self._participant = participant
        deadline = time.monotonic() + patience_s
        self._requests = self._data("request", deadline)
        self._answers = self._data("answer", deadline)
        wakes_us, wakes_other = self._event("request"), self._event("answer")
        # This end listens before the other end can send.
        self._listener = wakes_us.listener_builder().create()
        self._notifier = wakes_other.notifier_builder().create()
        self._publisher = (
            self._answers.publisher_builder()
            .initial_max_slice_len(SAMPLE_DOUBLES)
            .allocation_strategy(iox2.AllocationStrategy.Static)
            .backpressure_strategy(iox2.BackpressureStrategy.DiscardData)
            .max_loaned_samples(1)
            .create()
        )
        self._subscriber = self._requests.subscriber_builder().create()
        how = self._requests.attributes.key_values(iox2.AttributeKey.new("waiting"))
        polls = any(str(value) == "poll" for value in how)
        self._polling_s = POLLING_S if polls else POLLING_ON_SHARED_CORE_S
        self._slice = iox2.Duration.from_secs_f64(SLICE_S)
        self._connected = False
        self._begun: Optional[Tuple[bytes, int]] = None
        self._arriving = b""

    def _name(self, way: str) -> iox2.ServiceName:
        return iox2.ServiceName.new(f"{self._participant}/{way}")

    def _data(self, way: str, deadline: float) -> iox2.PortFactoryPublishSubscribe:
        while True:
            builder = (
                self._node.service_builder(self._name(way))
                .publish_subscribe(iox2.Slice[ctypes.c_double])
                .user_header(_Header)
                .enable_safe_overflow(False)
                .history_size(0)
                .subscriber_max_buffer_size(WAITING_SAMPLES)
                .subscriber_max_borrowed_samples(1)
                .max_publishers(1)
                .max_subscribers(1)
                .max_nodes(2)
            )
            try:
                return builder.open()
            except iox2.PublishSubscribeOpenError as error:
                # A service that is being created looks like a missing one.
                if time.monotonic() >= deadline:
                    raise LinkError(f"`{self._participant}` found no connection to the coordinator: {error}") from error
            time.sleep(1e-3)

    def _event(self, way: str) -> iox2.PortFactoryEvent:
        return self._node.service_builder(self._name(way)).event().open()

    def _has_left(self) -> bool:
        return self._connected and self._requests.dynamic_config.number_of_publishers == 0

    def _connect(self, deadline: float) -> None:
        while not self._connected:
            others = self._answers.dynamic_config.number_of_subscribers
            if others > 0 and self._requests.dynamic_config.number_of_publishers > 0:
                self._connected = True
            elif time.monotonic() >= deadline:
                raise LinkError("the coordinator did not connect")
            else:
                time.sleep(1e-4)

    def send(self, header: Header, payload: bytes, patience_s: float) -> None:
        """Sends one frame; a long one travels as full samples and a last one that is not full."""
        deadline = time.monotonic() + patience_s
        self._connect(deadline)
        packed = header.pack()
        full = 8 * SAMPLE_DOUBLES
        begun, at = self._begun or (packed, 0)
        if begun != packed:
            raise LinkError("an earlier frame was sent only in part, and only its rest can follow")
        while True:
            part = payload[at : at + full] if at or len(payload) >= full else payload
            self._send_sample(packed, part, deadline)
            at += full
            self._begun = (packed, at) if len(part) == full else None
            if self._begun is None:
                return

    def _send_sample(self, header: bytes, part: bytes, deadline: float) -> None:
        while True:
            sample = self._publisher.loan_slice_uninit(len(part) // 8)
            ctypes.memmove(sample.user_header_ptr, header, LAYOUT.size)
            ctypes.memmove(sample.payload_ptr, part, len(part))
            if sample.assume_init().send() > 0:
                self._notifier.notify()
                return
            if self._has_left():
                raise LinkError("the coordinator closed the connection")
            if time.monotonic() >= deadline:
                raise LinkFull("the coordinator took no frame in time")
            time.sleep(5e-5)

    def _take(self) -> Optional[Frame]:
        while (sample := self._subscriber.receive()) is not None:
            # This binding gives the payload's own length in bytes; the header is right.
            size = 8 * sample.header.number_of_elements
            part = ctypes.string_at(sample.payload_ptr, size)
            if size == 8 * SAMPLE_DOUBLES:
                self._arriving += part
                continue
            header = Header.unpack(ctypes.string_at(sample.user_header_ptr, LAYOUT.size))
            payload, self._arriving = self._arriving + part, b""
            return Frame(header, payload)
        return None

    def receive(self, patience_s: float) -> Optional[Frame]:
        """The next frame, or `None` if it did not come in time."""
        start = time.monotonic()
        looks = 0
        alone = True
        while True:
            if (frame := self._take()) is not None:
                self._connected = True
                return frame
            looks += 1
            # Looking for the coordinator costs as much as looking for a frame.
            if looks % LOOKS == 0 and self._has_left():
                # A frame from before it left may have arrived since.
                if (frame := self._take()) is not None:
                    return frame
                raise LinkError("the coordinator closed the connection")
            waited = time.monotonic() - start
            if waited >= patience_s:
                return None
            if alone and waited < self._polling_s:
                os.sched_yield()
                # A yield that returns late gave the core to another program that wants the whole core.
                alone = time.monotonic() - start - waited < LATE_YIELD_S
            else:
                looks = -1
                self._listener.timed_wait(self._slice)

    def clock_ahead_ns(self) -> int:
        """Lead of this host's clock over the coordinator's: both use the same clock."""
        return 0

    def close(self) -> None:
        """Does nothing: sent frames stay for the coordinator."""
