"""What stays at hand, and what is let go."""

from __future__ import annotations

import gc
import threading
import weakref
from dataclasses import dataclass
from typing import Any

from server.shelf import Recent, Shelf


@dataclass(eq=False)
class Heavy:
    """A product of so many bytes."""

    bytes: int


def heavy(size: int) -> Any:
    return Heavy(size)


def test_recent_keeps_what_was_used_last() -> None:
    recent: Recent[int, int] = Recent(2)
    recent.keep(1, 10)
    recent.keep(2, 20)
    assert recent.use(1) == 10
    recent.keep(3, 30)
    assert (recent.get(1), recent.get(2), recent.get(3)) == (10, None, 30)


def test_recent_by_size() -> None:
    """The newest stays, however large it is."""
    recent: Recent[str, int] = Recent(10, lambda value: value)
    for name, size in (("a", 4), ("b", 4), ("c", 4), ("d", 40)):
        recent.keep(name, size)
        kept = [name for name in "abcd" if recent.get(name)]
        assert kept == {"a": ["a"], "b": ["a", "b"], "c": ["b", "c"], "d": ["d"]}[name]


def test_what_a_product_takes_beside_its_transport_counts() -> None:
    shelf = Shelf(100)
    shelf.keep("a", heavy(30), 30)
    shelf.keep("b", heavy(30), 20)
    assert shelf.bytes == 50
    assert shelf.get("a") is None


def test_the_least_recently_used_are_let_go() -> None:
    shelf = Shelf(100)
    for name in "abc":
        shelf.keep(name, heavy(30))
    assert shelf.use("a") is not None
    shelf.keep("d", heavy(50))
    assert [name for name in "abcd" if shelf.get(name)] == ["a", "d"]
    assert shelf.bytes == 80


def test_looking_whether_it_is_there_is_no_use() -> None:
    shelf = Shelf(60)
    shelf.keep("a", heavy(30))
    shelf.keep("b", heavy(30))
    assert shelf.get("a") is not None
    shelf.keep("c", heavy(30))
    assert shelf.get("a") is None


def test_one_that_is_too_large_for_all_stays_alone() -> None:
    shelf = Shelf(10)
    shelf.keep("a", heavy(5))
    shelf.keep("b", heavy(500))
    assert (shelf.get("a"), shelf.bytes) == (None, 500)


def test_the_same_name_is_replaced() -> None:
    shelf = Shelf(100)
    first, second = heavy(60), heavy(70)
    shelf.keep("a", first)
    shelf.keep("a", second)
    assert shelf.get("a") is second
    assert shelf.bytes == 70


def test_a_product_in_use_outlives_the_shelf_and_not_by_more() -> None:
    shelf, product = Shelf(50), heavy(40)
    gone = weakref.ref(product)
    shelf.keep("a", product)
    del product
    view = shelf.use("a")
    shelf.keep("b", heavy(40))
    assert shelf.get("a") is None
    assert view is not None
    assert gone() is view.product
    del view
    gc.collect()
    assert gone() is None


def test_from_many_threads() -> None:
    shelf = Shelf(200)

    def work(seed: int) -> None:
        for k in range(500):
            shelf.keep((seed * k) % 17, heavy(30))
            shelf.use(k % 17)
            assert shelf.bytes <= 200

    threads = [threading.Thread(target=work, args=(seed,)) for seed in (3, 5, 7)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert shelf.bytes <= 200
