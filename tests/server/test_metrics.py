"""GET /metrics: how long frames take, in Prometheus' text format."""

from __future__ import annotations

import re

from httpx import Client

from server.metrics import PARTS, Metrics
from server.wire import FrameHeader

SAMPLE = re.compile(
    r'relight_[a-z_]+(\{[a-z]+="[A-Za-z0-9_.]+"(,[a-z]+="[A-Za-z0-9_.]+")*\})? -?[0-9.e+-]+'
)


def header(method: str = "direct", **timings: float) -> FrameHeader:
    return FrameHeader(
        seq=0, width=1, height=1, scale=1, format="png", method=method, timings=timings, warnings=[]
    )


def test_quantiles_are_those_of_the_frames() -> None:
    metrics = Metrics()
    for k in range(101):
        metrics.frame(header(relight=float(k), encode=1.0), "live", 0.002)
    text = metrics.text({"sessions": 3.0})
    assert 'relight_frame_seconds{part="relight",quantile="0.5"} 0.05\n' in text
    assert 'relight_frame_seconds{part="relight",quantile="0.95"} 0.095\n' in text
    assert 'relight_frame_seconds_sum{part="encode"} 0.101\n' in text
    assert 'relight_frame_seconds_count{part="answer"} 101\n' in text
    assert 'relight_frames_total{method="direct",way="live"} 101\n' in text
    assert "# TYPE relight_sessions gauge\nrelight_sessions 3\n" in text


def test_without_frames_there_are_no_quantiles() -> None:
    text = Metrics().text({})
    assert "quantile" not in text.replace("quantiles", "")
    assert 'relight_frame_seconds_count{part="relight"} 0\n' in text


def test_every_line_is_a_comment_or_a_sample() -> None:
    metrics = Metrics()
    metrics.frame(header("glossy_prt", relight=1.5), "http", 0.01)
    metrics.problem(422)
    for line in metrics.text({"jobs": 0.0}).splitlines():
        assert line.startswith("# ") or SAMPLE.fullmatch(line), line


def test_the_service_counts_frames_and_problems(client: Client) -> None:
    def value(name: str) -> float:
        answer = client.get("/metrics")
        assert answer.headers["content-type"] == "text/plain; version=0.0.4; charset=utf-8"
        found = re.search(rf"^{re.escape(name)} (\S+)$", answer.text, re.MULTILINE)
        return float(found[1]) if found else 0.0

    frames, refused = 'relight_frames_total{method="direct",way="http"}', "relight_problems_total"
    before = value(frames), value(refused + '{status="404"}')
    assert client.post("/api/scenes/tiny-box/frame", json={}).status_code == 200
    assert client.post("/api/scenes/nowhere/frame", json={}).status_code == 404
    assert value(frames) == before[0] + 1
    assert value(refused + '{status="404"}') == before[1] + 1
    for part in PARTS:
        if part != "buffer":
            assert value(f'relight_frame_seconds{{part="{part}",quantile="0.95"}}') > 0
    assert value("relight_sessions") == value("relight_frames_waiting") == 0


def test_it_is_not_kept_by_caches(client: Client) -> None:
    assert client.get("/metrics").headers["cache-control"] == "no-store"
