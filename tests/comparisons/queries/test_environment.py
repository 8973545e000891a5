"""What a result says of the machine that it was computed on."""

import platform
from pathlib import Path

from mbcheck.comparisons.queries.environment import processor


def test_the_processor_is_named_where_the_system_tells(tmp_path: Path) -> None:
    listed, other = tmp_path / "cpuinfo", platform.processor() or "unknown"
    assert processor(listed) == other
    listed.write_text("flags\t: fpu\n")
    assert processor(listed) == other
    listed.write_text("vendor_id\t: X\nmodel name\t: A Fast One \nflags\t: fpu\nmodel name\t: B\n")
    assert processor(listed) == "A Fast One"
