import numpy as np
import pytest

from experiments.seeding import Stream, generator


def test_the_same_address_gives_the_same_draws():
    first, second = (generator(3, Stream.SCENE).random(5) for _ in range(2))
    assert np.array_equal(first, second)


def test_streams_and_seeds_are_independent():
    draws = {
        (seed, stream): generator(seed, stream).random() for seed in range(20) for stream in Stream
    }
    assert len(set(draws.values())) == len(draws)


def test_the_order_of_requests_does_not_matter():
    generator(0, Stream.TRACKER).random(100)
    assert generator(7, Stream.SENSOR).random() == generator(7, Stream.SENSOR).random()


def test_worlds_are_pinned_for_all_time():
    assert generator(0, Stream.SCENE).integers(0, 2**32, 3).tolist() == [
        1191434737,
        3965302008,
        853307535,
    ]


def test_a_negative_seed_is_refused():
    with pytest.raises(ValueError, match="seed must be 0 or greater, got -1"):
        generator(-1, Stream.SCENE)


def test_places_have_streams_of_their_own():
    places = ["", "ope/Deer/1", "ope/Deer/2", "tre/Deer/1", "ope/Dear/1"]
    draws = [generator(0, Stream.VIDEO, place).random() for place in places]
    assert len(set(draws)) == len(draws)
    assert generator(0, Stream.VIDEO, "ope/Deer/1").random() == draws[1]
