// How many of n samples appear by chance: mkt.papers.lessons.chance.

// The probabilities of 0, 1, ..., n successes, each with probability p between 0 and 1.
export function binomial(n, p) {
  const log = [n * Math.log1p(-p)];
  const odds = Math.log(p) - Math.log1p(-p);
  for (let k = 1; k <= n; k++) log.push(log[k - 1] + Math.log((n - k + 1) / k) + odds);
  return log.map(Math.exp);
}

// The probability of more than each number of successes: the upper tails.
export function tails(probabilities) {
  let sum = 0;
  const above = probabilities.toReversed().map((each) => (sum += each) - each);
  return above.toReversed();
}

// The largest number of n samples that starts nothing; .29 x 100 is rounded to less
// than 29.
export const most = (b, n) => Math.floor(b * n + 1e-9);

// The probability that more than b n of n appear by chance.
export const falseStart = (n, p, b) => tails(binomial(n, p))[most(b, n)];
