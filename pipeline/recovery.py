"""What the conductor keeps of a section so that it can be started again: its last snapshot, and all requests since."""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from itertools import accumulate
from tempfile import TemporaryFile, gettempdir
from typing import IO

from pipeline.bus.messages import RESTORE, SETTINGS, STATE, STOPPED, WANT_STATE, Message, pack, pack_parts, readdressed
from pipeline.errors import HostError
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.lengths import Lengths
from pipeline.sections import Section

Numbers = bytes | memoryview  # float64, little-endian
STATE_BYTES = 64 << 10  # a snapshot up to this size comes with every reply
TAPE_BYTES = 64 << 20  # requests beyond this are kept in a temporary file


class Tape:
    """Requests in order: the last ones in memory, and where these were more than TAPE_BYTES, the first in a file."""

    def __init__(self) -> None:
        self._recent: list[bytes] = []
        self._bytes = 0
        self._file: IO[bytes] | None = None
        self._ends = [0]  # in the file

    def __len__(self) -> int:
        return len(self._ends) - 1 + len(self._recent)

    def __getitem__(self, i: int) -> bytes:
        spilled = len(self._ends) - 1
        if i >= spilled:
            return self._recent[i - spilled]
        assert self._file is not None
        self._file.seek(self._ends[i])
        return self._file.read(self._ends[i + 1] - self._ends[i])

    def append(self, data: bytes) -> None:
        """Add one. Raises HostError where it cannot be kept."""
        self._recent.append(data)
        self._bytes += len(data)
        if self._bytes > TAPE_BYTES:
            self._spill()

    def _spill(self) -> None:
        ends = [*accumulate(map(len, self._recent), initial=self._ends[-1])]
        try:
            self._file = self._file or TemporaryFile()  # noqa: SIM115 - closed by clear()
            self._file.seek(ends[0])
            self._file.writelines(self._recent)
            self._file.flush()
        except OSError as error:
            text = "cannot keep what a host that is started again would need"
            raise HostError(f"{text}, in {gettempdir()}: {error.strerror}; TMPDIR names another folder") from error
        self._ends += ends[1:]
        self._recent, self._bytes = [], 0

    def clear(self) -> None:
        """Forget all."""
        self._recent.clear()
        self._bytes = 0
        if self._file is not None:
            with suppress(OSError):  # of what could not be written
                self._file.close()
            self._file, self._ends = None, [0]


class Link:
    """The conductor's side of one section: requests numbered, replies taken in order.

    sequence: of the last request made. answered: of the last one that the host's present incarnation has answered.
    settings: the section's parameters and offsets as events left them. reply: to the last request answered.
    """

    def __init__(self, section: Section, lengths: Lengths, settings: bytes):
        """settings: at t0."""
        self.section = section
        self.lengths = lengths
        self.settings = settings
        self.sequence = self.answered = -1
        self.t_ns = section.graph.start_ns
        self.reply: Message | None = None
        self.state_every = 1 + 8 * (lengths.signals + lengths.energies + lengths.state) // STATE_BYTES
        self._tape = Tape()
        self._snapshot: tuple[Numbers, Numbers, Numbers, bytes] = b"", b"", b"", b""  # the last: what FMUs saved
        fmus = [node for node in section.graph.nodes if isinstance(node.component, FmuComponent)]
        able = [node.component.interface.can_save for node in fmus if isinstance(node.component, FmuComponent)]
        self.saving = [node.name for node, can_save in zip(fmus, able, strict=True) if can_save]
        self._keeps_all = not all(able)  # it can be started again only at t0, and fed all requests since
        self._brought: Message | None = None  # the reply that brought a later one
        self._kept = -1  # the sequence after which that was taken
        self._kept_settings = b""
        self._is_changed = False
        self._number = section.number
        self._bytes_of_reply = cache(lambda flags: 8 * lengths.reply(flags))

    @property
    def names(self) -> str:
        """Of its components, as one reads them in a message."""
        return ", ".join(node.name for node in self.section.graph.nodes)

    @property
    def is_answered(self) -> bool:
        """Whether no request is open."""
        return self.answered == self.sequence

    def change(self, settings: bytes) -> None:
        """Send these settings with the next request, if they are others."""
        if settings != self.settings:
            self.settings, self._is_changed = settings, True

    def make(self, kind: int, run: int, incarnation: int, t_ns: int, numbers: bytes, *, is_last: bool) -> bytes:
        """Make the next request, to be kept. is_last: of its block, after which the run may be saved."""
        self.sequence = sequence = self.sequence + 1
        self.t_ns = t_ns
        flags = WANT_STATE if is_last or sequence % self.state_every == 0 else 0
        if self._is_changed:
            flags |= SETTINGS
            numbers += self.settings
            self._is_changed = False
        return pack_parts(kind, run, incarnation, self._number, sequence, t_ns, flags, 0, len(numbers) // 8, (numbers,))

    def keep(self, request: bytes) -> None:
        """Keep the request just made, which may be under way already."""
        self._tape.append(request)

    def open_request(self, incarnation: int) -> bytes:
        """The request that the host has to answer next."""
        return readdressed(self._tape[self.answered - self._kept], incarnation)

    def take(self, message: Message) -> bool:
        """Take a reply in; False where it is not the one awaited."""
        sequence, flags = message.sequence, message.flags
        if sequence != self.answered + 1 or sequence > self.sequence:
            return False
        if len(message.numbers) != self._bytes_of_reply(flags):
            return False
        if flags & STOPPED and not 0 <= message.failed < len(self.section.nodes):
            return False
        self.answered, self.reply = sequence, message
        if flags & (STATE | STOPPED) == STATE and sequence == self.sequence:
            self._keep_state(message)
        return True

    def _keep_state(self, message: Message) -> None:
        """The state that it brought; the requests up to it are done with, unless all are needed."""
        self._brought = message
        self.state_every = 1 + (len(message.numbers) + len(message.text)) // STATE_BYTES
        if not self._keeps_all:
            self._kept, self._kept_settings = message.sequence, self.settings
            self._tape.clear()

    @property
    def snapshot(self) -> tuple[Numbers, Numbers, Numbers, bytes]:
        """The last one: signals, energies of bonds, states, what FMUs saved."""
        if self._brought is not None:
            numbers, of = self._brought.numbers, self.lengths
            energies = 8 * (of.signals + of.rows)
            states = energies + 8 * of.energies
            self._snapshot = (
                numbers[: 8 * of.signals],
                numbers[energies:states],
                numbers[states : states + 8 * of.state],
                self._brought.text,
            )
            self._brought = None
        return self._snapshot

    def begin_at(self, signals: bytes, energies: bytes, states: bytes, saved: bytes, settings: bytes) -> None:
        """Go on from a snapshot of the run."""
        self._snapshot = signals, energies, states, saved
        self.settings = self._kept_settings = settings
        self._kept = self.sequence = self.answered = 0

    def restart(self, run: int, incarnation: int) -> bytes | None:
        """What the host's next incarnation is to be restored with; None where it begins at t0."""
        self.answered = self._kept
        if self._kept < 0:
            return None
        *parts, saved = self.snapshot
        numbers = b"".join((*parts, self._kept_settings))
        place = self.section.number, self._kept, self.t_ns
        return pack(Message(RESTORE, run, incarnation, *place, numbers=numbers, text=saved))

    def close(self) -> None:
        """Forget everything."""
        self._tape.clear()
