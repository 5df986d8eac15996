"""Networks compared with plain torch; the genetic search: operators, chance, interruptions."""

import json
import os
import signal
import subprocess
import sys
import warnings
from concurrent.futures.process import BrokenProcessPool
from unittest import mock

import numpy as np
import pytest
import torch
from tables import linear_law, no_law
from workers import has_ended

from abradem.learning.baselines import ga_ann, genetic
from abradem.learning.baselines.ga_ann import fit_networks, settings
from abradem.learning.baselines.genetic import Chromosome, Memory, Options, SearchProblem, search
from abradem.learning.model_files import Model
from abradem.learning.network import Training, network_of, parameters_of, start, train
from abradem.learning.protocols import repeated_splits
from abradem.learning.rows import learning_table

SMALL = Options(population=6, generations=4, max_layers=3, min_neurons=2, max_neurons=20)
QUICK = Training(epochs=8, batch=16)


def problem(n=90, seed=0):
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((n, 5))
    y = x[:, 0] * x[:, 1] + x[:, 2]
    cut = 2 * n // 3
    return SearchProblem(x[:cut], y[:cut], x[cut:], y[cut:])


def plain(net, seed, x, y, training):
    """The same training with the layers, gradients and optimiser of torch."""
    layers = []
    for weights, biases in zip(net.weights, net.biases, strict=True):
        layer = torch.nn.Linear(*weights.shape)
        layer.weight.data = torch.from_numpy(weights.T.copy())
        layer.bias.data = torch.from_numpy(biases.copy())
        layers += [layer, torch.nn.ReLU()]
    model = torch.nn.Sequential(*layers[:-1])
    adam = torch.optim.Adam(model.parameters(), lr=training.learning_rate)
    rng = np.random.default_rng([seed, 1])
    rows = torch.from_numpy(x.astype(np.float32))
    target = torch.from_numpy(y.astype(np.float32))[:, None]
    for _ in range(training.epochs):
        order = torch.from_numpy(rng.permutation(len(y)))
        for first in range(0, len(y), training.batch):
            part = order[first : first + training.batch]
            adam.zero_grad()
            torch.nn.functional.mse_loss(model(rows[part]), target[part]).backward()
            adam.step()
    with torch.no_grad():
        return model(rows)[:, 0].numpy()


# Training


@pytest.mark.parametrize("hidden", [(7,), (12, 5), (9, 30, 4)])
def test_training_is_that_of_plain_torch(hidden):
    given = problem()
    net = start(5, hidden, seed=3)
    (trained,) = train([net], [3], given.x, given.y, QUICK)
    expected = plain(net, 3, given.x, given.y, QUICK)
    np.testing.assert_allclose(trained.predict(given.x), expected, rtol=1e-3, atol=1e-4)


def test_a_batch_of_padded_networks_trains_as_they_do_alone():
    given = problem()
    shapes = [(12, 5), (3, 20), (8, 8)]
    nets = [start(5, hidden, seed) for seed, hidden in enumerate(shapes)]
    together = train(nets, [0, 1, 2], given.x, given.y, QUICK)
    for seed, (net, found) in enumerate(zip(nets, together, strict=True)):
        (alone,) = train([net], [seed], given.x, given.y, QUICK)
        assert [w.shape for w in found.weights] == [w.shape for w in net.weights]
        np.testing.assert_allclose(
            found.predict(given.x), alone.predict(given.x), rtol=1e-3, atol=1e-4
        )


def test_a_network_learns_a_law_that_is_not_linear():
    given = problem(240)
    (net,) = train([start(5, (40, 40), 1)], [1], given.x, given.y, Training(150, 32, 3e-3))
    error = given.fitness_y - net.predict(given.fitness_x)
    assert error.var() < 0.15 * given.fitness_y.var()


def test_inherited_weights_replace_what_overlaps():
    parent, child = start(5, (6, 4), 1), start(5, (3, 8, 2), 2, start(5, (6, 4), 1))
    np.testing.assert_array_equal(child.weights[0], parent.weights[0][:, :3])
    np.testing.assert_array_equal(child.weights[1][:, :4], parent.weights[1][:3])
    np.testing.assert_array_equal(child.weights[3], parent.weights[2][:2])
    fresh = start(5, (3, 8, 2), 2)
    np.testing.assert_array_equal(child.weights[1][:, 4:], fresh.weights[1][:, 4:])


def test_weights_survive_their_file():
    net = start(4, (3, 2), 5)
    again = network_of(net.arrays())
    for a, b in zip([*net.weights, *net.biases], [*again.weights, *again.biases], strict=True):
        np.testing.assert_array_equal(a, b)
    assert parameters_of(4, (3, 2)) == 5 * 3 + 4 * 2 + 3


# Operators


def test_children_stay_within_the_limits_and_hold_their_parents_layers():
    rng = np.random.default_rng(0)
    options = Options()
    lengths = set()
    for _ in range(300):
        a, b = (tuple(rng.integers(10, 501, rng.integers(2, 7)).tolist()) for _ in range(2))
        children = genetic.crossover(a, b, options, rng)
        assert sorted([*a, *b]) == sorted([*children[0], *children[1]])
        for child in children:
            assert options.min_layers <= len(child) <= options.max_layers
            lengths.add(len(child))
    assert lengths == {2, 3, 4, 5, 6}


def test_mutation_changes_one_layer_by_up_to_its_size():
    rng = np.random.default_rng(0)
    for _ in range(200):
        layers = (10, 200, 500)
        mutant = genetic.mutate(layers, Options(), rng)
        changed = [i for i in range(3) if mutant[i] != layers[i]]
        assert len(changed) <= 1
        assert all(10 <= neurons <= 500 for neurons in mutant)
        assert all(abs(mutant[i] / layers[i] - 1.0) <= 0.2 + 1e-9 for i in changed)


@pytest.mark.parametrize("selection", genetic.SELECTIONS)
def test_the_fitter_are_picked_more_often(selection):
    rng = np.random.default_rng(0)
    options = Options(population=5, selection=selection)
    fitness = np.array([0.1, 0.9, 0.5, -3.0, genetic.FAILED])
    picked = np.bincount([genetic.pick(fitness, options, rng) for _ in range(2000)], minlength=5)
    assert picked[1] > picked[2] > picked[0] > picked[3]
    if selection == "roulette":
        # In proportion to the fitness above the worst, which counts as -1: 1.9 against 1.1.
        assert picked[1] / picked[0] == pytest.approx(1.9 / 1.1, rel=0.15)
        assert picked[3] == picked[4] == 0


def test_roulette_tells_good_networks_apart():
    rng = np.random.default_rng(0)
    options = Options(population=3, selection="roulette")
    fitness = np.array([0.9, 0.94, 0.98])
    picked = np.bincount([genetic.pick(fitness, options, rng) for _ in range(900)], minlength=3)
    assert picked[0] == 0 and picked[2] / picked[1] == pytest.approx(2.0, rel=0.25)
    # With equal fitness all have the same probability.
    picked = np.bincount([genetic.pick(np.full(3, -5.0), options, rng) for _ in range(900)])
    assert picked.min() > 200


def test_impossible_options_are_named():
    for options, words in (
        (Options(selection="lottery"), "selection = 'lottery' is unknown"),
        (Options(min_layers=7), "min_layers = 7"),
        (Options(elites=10), "elites = 10"),
    ):
        with pytest.raises(ValueError, match=words):
            search(problem(), options)


# Search


def test_the_published_search_scales_the_wear_only_where_the_paper_did():
    """As it is in the search, standardised over all rows in the final training; features always."""
    table = learning_table(linear_law(60, 0.1, 3))
    split = ga_ann.published_network_split(table)
    wear, features = table.target, table.features[:, split.columns]
    mean, scale = features.mean(axis=0), features.std(axis=0)
    search = ga_ann._problem(table, split)
    np.testing.assert_array_equal(search.y, wear[split.train])
    np.testing.assert_array_equal(search.fitness_y, wear[split.test])
    np.testing.assert_allclose(search.x, (features[split.train] - mean) / scale, atol=1e-12)
    of_x, of_y = split.final_scalers
    np.testing.assert_allclose(of_y.forward(wear), (wear - wear.mean()) / wear.std(), atol=1e-12)
    np.testing.assert_allclose(of_x.forward(features), (features - mean) / scale, atol=1e-12)
    # Without leakage both are standardised over the rows that are trained on.
    inner = ga_ann.leakage_free_split(table, split.train, split.test, 0.25, 12, [1, 2])
    fitted = ga_ann._problem(table, inner).y
    assert fitted.mean() == pytest.approx(0.0, abs=1e-12) and fitted.std() == pytest.approx(1.0)


def test_the_best_never_gets_worse_and_the_search_improves():
    options = SMALL._replace(population=8, generations=15, max_neurons=60)
    gains = []
    for seed in range(3):
        found = search(problem(), options, Training(12, 16, 3e-3), seed=seed)
        fitness = found.history.groupby("generation")["fitness"]
        best, median = fitness.max(), fitness.median()
        assert (np.diff(best) >= 0.0).all() and found.fitness == best.max()
        assert median.iloc[-1] > median.iloc[0] + 0.2
        gains.append(best.iloc[-1] - best.iloc[0])
    assert np.mean(gains) > 0.05


@pytest.mark.parametrize("weights", genetic.WEIGHTS)
def test_the_number_of_cores_changes_nothing(weights):
    options = SMALL._replace(weights=weights)
    one = search(problem(), options, QUICK, seed=1, cores=1)
    two = search(problem(), options, QUICK, seed=1, cores=2)
    assert one.history.equals(two.history) and one.best == two.best
    for a, b in zip(one.network.weights, two.network.weights, strict=True):
        np.testing.assert_array_equal(a, b)


def test_the_threads_of_linear_algebra_change_nothing():
    """Snakemake sets the number of threads to the cores of the rule."""
    from threadpoolctl import threadpool_limits

    rng = np.random.default_rng(0)
    x = rng.standard_normal((200, 12))
    large = SearchProblem(x, x[:, 0], x, x[:, 0])
    options = Options(population=2, generations=1, min_layers=3, max_layers=3, min_neurons=400)
    found = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            found.append(search(large, options, Training(1, 100)).history)
    assert found[0].equals(found[1])


def test_a_worker_that_is_killed_ends_the_search_instead_of_stopping_it(monkeypatch):
    def killed(*_):
        os.kill(os.getpid(), signal.SIGKILL)

    monkeypatch.setattr(genetic, "start", killed)
    with pytest.raises(BrokenProcessPool):
        search(problem(), SMALL, QUICK, cores=2)


def test_workers_end_with_the_process_that_they_work_for():
    code = """
import os, numpy as np
from abradem.learning.baselines import ga_ann, genetic
def told(*_):
    os.write(1, b'%d\\n' % os.getpid())  # in one piece, as both workers write
    __import__("time").sleep(60)
genetic.start = told
x = np.zeros((9, 2))
genetic.search(genetic.SearchProblem(x, x[:, 0], x, x[:, 0]), cores=2)
"""
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    worker = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    assert has_ended(worker, 5.0)


def test_networks_are_counted_with_the_weights_that_they_inherit():
    once = search(problem(), SMALL._replace(mutation=0.0, crossover=0.0), QUICK, seed=1)
    assert once.trained == SMALL.population
    same = SMALL._replace(mutation=0.0, crossover=0.0, weights="inherited", elites=1)
    inherited = search(problem(), same, QUICK, seed=1)
    # Every child starts from the weights of a parent, so it is a different network.
    assert inherited.trained > SMALL.population


def test_another_seed_is_another_search():
    histories = [search(problem(), SMALL, QUICK, seed=seed).history for seed in (1, 2)]
    assert not histories[0]["layers"].equals(histories[1]["layers"])


def test_a_chromosome_met_before_is_not_trained_again(monkeypatch):
    trained = []
    original = genetic.train
    monkeypatch.setattr(
        genetic, "train", lambda starts, *rest: trained.append(1) or original(starts, *rest)
    )
    found = search(problem(), SMALL._replace(mutation=0.0, crossover=0.0), QUICK, seed=1)
    # Without variation only the first generation is new; the best is trained once more at the end.
    assert len(trained) == SMALL.population + 1
    assert set(found.history["origin"]) == {"random", "elite", "copy"}


@pytest.mark.parametrize("weights", genetic.WEIGHTS)
def test_an_interrupted_search_resumes_to_the_same_end(tmp_path, weights):
    options = SMALL._replace(weights=weights)
    whole = search(problem(), options, QUICK, seed=1)

    class Interrupted(Exception):
        pass

    def stop(line):
        if line.startswith("generation 3"):
            raise Interrupted

    folder = tmp_path / "state"
    with pytest.raises(Interrupted):
        search(problem(), options, QUICK, seed=1, memory=Memory(folder, "a"), progress=stop)
    # Cut short in the middle of a line.
    with open(folder / "fitness.jsonl", "a") as file:
        file.write('["0123')
    kept = Memory(folder, "a")
    assert len(kept.fitness) >= SMALL.population
    resumed = search(problem(), options, QUICK, seed=1, memory=kept)
    assert resumed.history.equals(whole.history)
    assert Memory(folder, "another").fitness == {}


def changed_digit(folder):
    """Another fitness, in a line that is still JSON."""
    path = folder / "fitness.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    key, fitness, *rest = json.loads(lines[2])
    path.write_text(
        "".join([*lines[:2], json.dumps([key, 0.5 * fitness, *rest]) + "\n", *lines[3:]])
    )


def changed_bytes(folder):
    path = folder / "fitness.jsonl"
    content = bytearray(path.read_bytes())
    content[content.index(b"\n") + 9] ^= 0x80
    path.write_bytes(content)


def changed_network(folder):
    """A flipped bit of a weight, which safetensors does not notice."""
    path = sorted(folder.glob("*.safetensors"))[0]
    content = bytearray(path.read_bytes())
    content[-2] ^= 0x40
    path.write_bytes(content)


def lost_network(folder):
    sorted(folder.glob("*.safetensors"))[0].unlink()


@pytest.mark.parametrize("harm", [changed_digit, changed_bytes, changed_network, lost_network])
def test_what_is_damaged_of_a_kept_search_is_trained_again(tmp_path, harm):
    options = SMALL._replace(weights="inherited")
    whole = search(problem(), options, QUICK, seed=1, memory=Memory(tmp_path / "state", "a"))
    kept = Memory(tmp_path / "state", "a").fitness
    harm(tmp_path / "state")
    left = Memory(tmp_path / "state", "a")
    assert len(left.fitness) == len(kept) - 1 and left.fitness.items() <= kept.items()
    resumed = search(problem(), options, QUICK, seed=1, memory=left)
    assert resumed.history.equals(whole.history) and resumed.fitness == whole.fitness


def test_the_lineage_leads_from_the_best_to_the_first_generation():
    found = search(problem(), SMALL, QUICK, seed=3)
    rows = found.history.set_index(["generation", "individual"])
    assert found.lineage[-1][0] == 0
    for (generation, individual), (above, parent) in zip(
        found.lineage, found.lineage[1:], strict=False
    ):
        assert above == generation - 1
        assert rows.loc[(generation, individual), "parent_a"] == parent
    best = rows.loc[found.lineage[0]]
    assert best["layers"] == "-".join(map(str, found.best.layers))
    assert best["fitness"] == found.fitness


def test_progress_says_how_far_it_is():
    lines = []
    search(problem(), SMALL, QUICK, progress=lines.append)
    assert len(lines) == SMALL.generations
    assert lines[1].startswith("generation 2 of 4, best R2 ") and lines[1].endswith(" s left")


def test_a_missing_graphics_card_is_one_line():
    if torch.cuda.is_available():
        pytest.skip("there is one")
    with pytest.raises(ValueError, match="device: cuda: torch finds no graphics card"):
        search(problem(), SMALL, QUICK, device="cuda")


def test_on_a_graphics_card_networks_of_equal_depth_are_one_batch(monkeypatch):
    depths = []
    original = genetic.train

    def on_the_processor(starts, seeds, x, y, training, device):
        assert device == "cuda"
        depths.append([len(net.weights) for net in starts])
        return original(starts, seeds, x, y, training, "cpu")

    expected = search(problem(), SMALL._replace(generations=1), QUICK, seed=1)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(genetic, "train", on_the_processor)
    found = search(problem(), SMALL._replace(generations=1), QUICK, seed=1, device="cuda")
    assert all(len(set(batch)) == 1 for batch in depths)
    assert len(depths) - 1 == found.history["layers"].str.count("-").nunique()
    np.testing.assert_allclose(found.history["fitness"], expected.history["fitness"], atol=1e-3)


def test_equal_chromosomes_have_equal_keys():
    assert Chromosome((3, 4), 5).key == Chromosome((3, 4), 5).key
    keys = {Chromosome(*gene).key for gene in (((3, 4), 5), ((4, 3), 5), ((3, 4), 6))}
    assert len(keys | {Chromosome((3, 4), 5, "x").key}) == 4


# Protocols


OPTIONS = {
    "options": SMALL._replace(generations=5, population=8),
    "training": QUICK,
    "final": Training(10, 16),
    "retrainings": 5,
    "repeats": 2,
    "seed": 1,
}


@pytest.fixture(scope="module")
def of_noise():
    """Both protocols on data without any relation, so that good scores are due to chance."""
    longer = Training(30, 16, 3e-3)
    options = SMALL._replace(population=10, generations=6, max_neurons=40)
    varied = {"options": options, "training": longer, "final": longer, "retrainings": 9}
    table = learning_table(no_law(60))
    return {
        p: fit_networks(table, p, **{**OPTIONS, **varied}) for p in ("as_published", "leakage_free")
    }


def r2(result, split, model="ga_ann"):
    rows = result.results.scores.query("metric == 'R2' and split == @split and model == @model")
    return rows["value"].to_numpy()


def test_looking_at_the_test_rows_is_optimistic_where_there_is_nothing_to_learn(of_noise):
    published, leakage_free = of_noise["as_published"], of_noise["leakage_free"]
    # Retraining the same network reveals that the best score is due to chance.
    assert r2(published, "test")[0] > np.median(r2(published, "retrained")) + 0.2
    assert r2(published, "test")[0] > 0.1 > r2(leakage_free, "test")[0]
    assert r2(published, "test")[0] >= r2(published, "search")[0]
    # Leakage-free, the score is optimistic on the validation rows but not on the test rows.
    assert r2(leakage_free, "search")[0] > r2(leakage_free, "test")[0] + 0.1
    assert r2(leakage_free, "test")[0] == r2(leakage_free, "retrained")[0]


def test_leakage_free_searches_do_not_touch_the_test_rows():
    frame = linear_law(60, 0.2)
    one = {**OPTIONS, "repeats": 1}
    first = fit_networks(learning_table(frame), "leakage_free", **one)
    tested = first.results.predictions.query("model == 'ga_ann'")["case_id"]
    changed = frame.copy()
    changed.loc[changed["case_id"].isin(tested), "wear_total_mean"] += 50.0
    second = fit_networks(learning_table(changed), "leakage_free", **one)
    assert first.history.equals(second.history)
    np.testing.assert_array_equal(
        first.results.predictions["predicted"], second.results.predictions["predicted"]
    )


def test_more_searches_take_other_splits_and_the_first_stays():
    table = learning_table(linear_law(60, 0.2))
    quick = {**OPTIONS, "options": SMALL._replace(generations=2, population=4), "retrainings": 1}
    one = fit_networks(table, "leakage_free", **quick)
    two = fit_networks(table, "leakage_free", **quick, searches=2)
    assert r2(two, "test")[0] == r2(one, "test")[0] and len(r2(two, "test")) == 2
    assert two.history["repeat"].unique().tolist() == [0, 1]
    assert (one.summary["splits"], len(one.summary["searches"])) == (2, 1)
    assert (two.summary["splits"], len(two.summary["searches"])) == (2, 2)
    # There is one search for each split at most.
    more = fit_networks(table, "leakage_free", **quick, searches=5)
    assert more.history.equals(two.history) and more.summary == two.summary


def test_networks_are_scored_on_the_splits_of_all_models_whatever_the_cores():
    frame = linear_law(60, 0.2)
    table = learning_table(frame)
    quick = {**OPTIONS, "options": SMALL._replace(generations=1, population=2), "retrainings": 1}
    with mock.patch.object(ga_ann, "NETWORK", (6, 5)):
        one, two = (
            fit_networks(table, "leakage_free", **{**quick, "repeats": 3}, cores=cores)
            for cores in (1, 2)
        )
    assert one.results.scores.equals(two.results.scores)
    assert one.results.predictions.equals(two.results.predictions)
    rows = one.results.predictions
    for repeat, (_, test) in enumerate(repeated_splits(table.keys, table.groups, 0.2, 3, 1)):
        for model in ("ga_ann", "paper_net"):
            mine = rows[(rows["model"] == model) & (rows["repeat"] == repeat)]
            np.testing.assert_array_equal(mine["case_id"], table.keys[test])


def test_a_network_on_a_further_split_learns_nothing_from_its_test_rows():
    frame = linear_law(60, 0.2)
    table = learning_table(frame)
    quick = {**OPTIONS, "options": SMALL._replace(generations=1, population=2), "retrainings": 1}
    (first, _), (other, tested) = repeated_splits(table.keys, table.groups, 0.2, 2, 1)
    # Rows of the search in the first split choose the architecture, others do not.
    only = np.setdiff1d(tested, first)
    assert len(only) and len(other)
    changed = frame.copy()
    changed.loc[changed["case_id"].isin(table.keys[only]), "wear_total_mean"] += 50.0
    with mock.patch.object(ga_ann, "NETWORK", (6, 5)):
        before, after = (
            fit_networks(learning_table(rows), "leakage_free", **quick).results.predictions.query(
                "repeat == 1"
            )
            for rows in (frame, changed)
        )
    np.testing.assert_array_equal(before["predicted"], after["predicted"])
    assert not np.array_equal(before["actual"], after["actual"])


def test_a_network_on_a_further_split_learns_from_its_own_training_rows():
    table = learning_table(linear_law(60, 0.2))
    quick = {**OPTIONS, "options": SMALL._replace(generations=1, population=2), "retrainings": 1}
    with (
        mock.patch.object(ga_ann, "NETWORK", (6, 5)),
        mock.patch.object(genetic, "train_each", wraps=genetic.train_each) as trained,
    ):
        fit_networks(table, "leakage_free", **{**quick, "repeats": 3})
    (_, lessons, *_), _ = trained.call_args
    splits = list(repeated_splits(table.keys, table.groups, 0.2, 3, 1))
    # The network found, and that of the paper, on the second and third split.
    for lesson, number in zip(lessons, (1, 2, 1, 2), strict=True):
        rows = table.target[splits[number][0]]
        np.testing.assert_allclose(lesson.y, (rows - rows.mean()) / rows.std(), rtol=1e-6)


def test_networks_trained_each_on_its_own_rows_are_those_trained_alone():
    rng = np.random.default_rng(4)
    lessons = [
        genetic.Lesson(seed, rng.standard_normal((30 + seed, 3)), rng.standard_normal(30 + seed))
        for seed in range(3)
    ]
    layers = [(4,), (5, 3), (4,)]
    found = genetic.train_each(layers, lessons, QUICK, cores=2)
    for one, lesson, network in zip(layers, lessons, found, strict=True):
        (alone,) = genetic.train_again(one, [lesson.seed], lesson.x, lesson.y, QUICK)
        for ours, theirs in zip(network.weights, alone.weights, strict=True):
            np.testing.assert_array_equal(ours, theirs)


def test_the_networks_file_predicts_the_scored_rows(of_noise):
    rows = no_law(60)
    for result in of_noise.values():
        model = Model(*result.model)
        stored = result.results.predictions.query("model == 'ga_ann' and repeat == 0")
        with warnings.catch_warnings():
            # Test rows may lie outside the training ranges.
            warnings.simplefilter("ignore", UserWarning)
            predicted = model.predict(rows.set_index("case_id").loc[stored["case_id"]])
        np.testing.assert_allclose(predicted, stored["predicted"], rtol=1e-5)
        assert json.dumps(result.summary, default=float)
        summary = result.summary
        assert summary["lineage"][0]["fitness"] == summary["best_fitness"]
        assert summary["generations"][-1]["best_fitness"] == summary["best_fitness"]


def test_settings_come_from_the_configuration():
    from abradem.config import Config

    found = settings(Config(study="a").learning.ga_ann.model_dump())
    assert found["options"] == Options() and found["training"] == Training()
    assert found["final"] == Training(epochs=60, batch=50)
    assert {"validation_share", "retrainings", "searches", "device"} <= found.keys()
