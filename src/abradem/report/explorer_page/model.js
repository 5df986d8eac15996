// The surrogate in the page: the same arithmetic as abradem.surrogate, in double precision.
// `dimensionlessGroups` and `wearScale` are written by abradem.surrogate.javascript.
"use strict";

const Model = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);

  // An array that was stored as text: {type, shape, text} with base64 of little-endian numbers.
  function decoded(stored) {
    const bytes = Uint8Array.from(atob(stored.text), (mark) => mark.charCodeAt(0));
    const numbers = stored.type === "f4" ? Float32Array : Float64Array;
    return Float64Array.from(new numbers(bytes.buffer));
  }

  const scaling = { mean: decoded(data.group_mean), scale: decoded(data.group_scale) };
  const rates = data.rates.map((rate) => ({
    ...rate,
    mean: rate.mean.map(layer),
    spread: rate.spread.map(layer),
    scores: decoded(rate.scores),
  }));
  const domain = data.domain && {
    ...data.domain,
    rows: decoded(data.domain.rows),
    slopes: decoded(data.domain.slopes),
  };
  const maps = data.maps && {
    ...data.maps,
    ...Object.fromEntries(Object.entries(data.maps.arrays).map(([name, one]) => [name, decoded(one)])),
  };

  function layer(stored) {
    return {
      weights: decoded(stored.weights),
      biases: decoded(stored.biases),
      outputs: stored.weights.shape[1],
    };
  }

  // Network with rectified linear units between its layers.
  function run(layers, inputs) {
    let values = inputs;
    layers.forEach(({ weights, biases, outputs }, place) => {
      const found = Float64Array.from(biases);
      values.forEach((value, row) => {
        const input = place ? Math.max(value, 0) : value;
        if (input === 0) return;
        for (let column = 0; column < outputs; column += 1)
          found[column] += input * weights[row * outputs + column];
      });
      values = found;
    });
    return values[0];
  }

  function standardised(values) {
    return Float64Array.from(
      dimensionlessGroups(values),
      (group, place) => (group - scaling.mean[place]) / scaling.scale[place],
    );
  }

  // Quantile of the held-out errors for a conformal interval, as conformal_quantile.
  function quantile(scores, confidence) {
    const rank = Math.max(1, Math.ceil((scores.length + 1) * confidence - 1e-9));
    return rank <= scores.length ? scores[rank - 1] : Infinity;
  }

  function logNumber(rate, z) {
    return { mean: run(rate.mean, z), spread: run(rate.spread, z) };
  }

  function predict(values, confidence, which = rates) {
    const z = standardised(values);
    const scale = wearScale(values);
    return which.map((rate) => {
      const { mean: own, spread } = logNumber(rate, z);
      const bound = rate.at_least && rates.find(({ name }) => name === rate.at_least);
      const mean = bound ? Math.max(own, logNumber(bound, z).mean) : own;
      const median = scale * Math.exp(mean);
      const ratio = Math.exp(quantile(rate.scores, confidence) * Math.exp(spread));
      return { rate: median, lower: median / ratio, upper: median * ratio };
    });
  }

  // Highest level of an interval that the held-out errors can promise.
  function highestLevel() {
    return Math.min(...rates.map(({ scores }) => scores.length / (scores.length + 1)));
  }

  function secondOrder(z) {
    const terms = [1, ...z];
    for (let i = 0; i < z.length; i += 1)
      for (let j = i; j < z.length; j += 1) terms.push(z[i] * z[j]);
    return terms;
  }

  // Wear depth rate of the elements, row by row along the slope, mm/s. With `mean`, the rate in the
  // mean over the plate, the map is scaled to it.
  function wearMap(values, mean = null) {
    const [nx, nz] = maps.counts;
    const z = dimensionlessGroups(values).map((group, place) => {
      const inside = Math.min(Math.max(group, maps.group_low[place]), maps.group_high[place]);
      return (inside - maps.group_mean[place]) / maps.group_scale[place];
    });
    const terms = secondOrder(z);
    const columns = maps.modes.length / (nx * nz) + 1;
    const found = new Float64Array(columns);
    terms.forEach((term, row) => {
      for (let column = 0; column < columns; column += 1)
        found[column] += term * maps.coefficients[row * columns + column];
    });
    const worn = Float64Array.from(maps.mean_map, (log, place) => {
      let sum = log;
      for (let mode = 1; mode < columns; mode += 1)
        sum += found[mode] * maps.modes[(mode - 1) * nx * nz + place];
      return Math.max(Math.exp(sum) - maps.floor, 0);
    });
    const average = worn.reduce((a, b) => a + b, 0) / worn.length;
    const level = mean === null ? wearScale(values) * Math.exp(found[0]) : mean;
    return worn.map((one) => level * (average > 0 ? one / average : 1));
  }

  // Distances of the training cases in the groups, weighted by their influence where it is known.
  function distances(z, rows, count) {
    const weights = domain ? domain.slopes : null;
    return Array.from({ length: count }, (_, row) => {
      let sum = 0;
      for (let place = 0; place < z.length; place += 1) {
        const away = (z[place] - rows[row * z.length + place]) * (weights ? weights[place] : 1);
        sum += away * away;
      }
      return Math.sqrt(sum);
    });
  }

  function isFar(z) {
    const found = distances(z, domain.rows, domain.rows.length / z.length).sort((a, b) => a - b);
    const nearest = found.slice(0, domain.neighbours);
    return nearest.reduce((a, b) => a + b, 0) / nearest.length > domain.limit;
  }

  // Whether the prediction depends on how far a quantity is beyond its range.
  function moves(values, quantity) {
    const end = Math.min(Math.max(values[quantity.name], quantity.low), quantity.high);
    const here = logNumber(rates[0], standardised(values));
    const there = logNumber(rates[0], standardised({ ...values, [quantity.name]: end }));
    return !(Math.abs(here.mean - there.mean) <= data.harmless * Math.exp(here.spread));
  }

  // Quantities beyond their training ranges that matter, and whether the case is far from all.
  function outside(values) {
    const beyond = data.quantities.filter(
      ({ name, least, most }) =>
        name !== "archard_constant" && (values[name] < least || values[name] > most),
    );
    const named = beyond.filter((one) => one.fixed || moves(values, one));
    return { quantities: named, far: Boolean(domain) && !named.length && isFar(standardised(values)) };
  }

  const cases = data.cases && {
    ...data.cases,
    values: decoded(data.cases.values),
    rates: decoded(data.cases.rates),
  };

  function caseValues(row) {
    const width = data.quantities.length;
    return Object.fromEntries(
      data.quantities.map(({ name }, place) => [name, cases.values[row * width + place]]),
    );
  }

  let caseGroups = null;
  function nearestCases(values, count) {
    if (!cases) return [];
    caseGroups ??= Float64Array.from(
      cases.ids.flatMap((_, row) => Array.from(standardised(caseValues(row)))),
    );
    const found = distances(standardised(values), caseGroups, cases.ids.length);
    return found
      .map((distance, row) => ({ distance, row, id: cases.ids[row], rate: cases.rates[row] }))
      .sort((a, b) => a.distance - b.distance || a.row - b.row)
      .slice(0, count);
  }

  return {
    data, rates, maps, predict, highestLevel, wearMap, outside, nearestCases, caseValues,
  };
})();
