"""Errors become problem documents that leak nothing."""

from __future__ import annotations

import errno
import logging

import pytest

from engine import errors
from server.problems import Busy, describe, response


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (errors.SceneError("too bright", field="lights.0", file="/a/b/c.json"), 422),
        (errors.EditNotSupported("no", field="camera"), 422),
        (errors.NotFound("no such scene"), 404),
        (errors.StoreError("damaged"), 500),
        (errors.BackendError("no GL"), 503),
        (errors.Cancelled("stopped"), 409),
        (Busy("later"), 503),
    ],
)
def test_every_error_has_its_status(error: errors.RelightError, status: int) -> None:
    problem = describe(error)
    assert problem.status == status
    assert problem.detail


def test_folders_stay_at_home() -> None:
    problem = describe(errors.SceneError("too bright", field="lights.0", file="/a/b/c.json"))
    assert (problem.file, problem.field, problem.detail) == ("c.json", "lights.0", "too bright")
    assert "/a/b" not in problem.model_dump_json()


def test_a_disk_that_refuses_is_said_without_its_folders() -> None:
    for error in (
        errors.StoreError("cannot be written: no space", file="/a/b/c.relight"),
        OSError(errno.ENOSPC, "no space", "/a/b/c"),
        OSError(errno.EROFS, "no space", "/a/b/c"),
    ):
        problem = describe(error)
        assert problem.status == 500
        assert "no space" in problem.detail
        assert "/a/b" not in problem.model_dump_json()


def test_unexpected_errors_are_logged_and_not_shown(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR):
        problem = describe(ValueError("the secret"))
    assert problem.status == 500
    assert "secret" not in problem.model_dump_json()
    assert "the secret" in caplog.text


def test_busy_says_when_to_come_back() -> None:
    assert response(describe(Busy("later"))).headers["retry-after"] == "1"
