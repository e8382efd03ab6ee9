"""How pages look: one column of text with its titles beside it, in light and in dark."""

from __future__ import annotations

STYLE = """
:root {
  --paper: #fcfbfa; --sunk: #f4f2ee; --ink: #2b2826; --quiet: #716b65; --line: #e3dfd9;
  --good: #2c7a4b; --bad: #b3372b; --doubt: #96650c; --bad-wash: #b3372b14;
  --mono: ui-monospace, "SF Mono", "Cascadia Mono", Menlo, Consolas, "Liberation Mono", monospace;
}
@media (prefers-color-scheme: dark) {
  :root {
    --paper: #191817; --sunk: #22201f; --ink: #e8e4df; --quiet: #a19a92; --line: #383532;
    --good: #6fbf8b; --bad: #ee8073; --doubt: #d9ab55; --bad-wash: #ee80731f;
  }
  img { filter: brightness(0.88); }
}
* { box-sizing: border-box; margin: 0; padding: 0; }
html { -webkit-text-size-adjust: 100%; }
body {
  background: var(--paper); color: var(--ink); margin: 0 auto; max-width: 76rem;
  padding: clamp(1.25rem, 4vw, 4rem) clamp(1rem, 4vw, 3.5rem) 2rem;
  font: 1rem/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "Liberation Sans",
    Arial, sans-serif;
  font-variant-numeric: tabular-nums;
}
img { border-radius: 4px; display: block; height: auto; max-width: 100%; }
ol, ul { list-style: none; }
code, pre { font-family: var(--mono); font-size: 0.85em; }
p, li, td:first-child, figcaption, dt, dd { overflow-wrap: anywhere; }
time, small { color: var(--quiet); font-size: 0.85rem; }

h1 {
  font-size: clamp(1.9rem, 5vw, 2.75rem); font-weight: 650; letter-spacing: -0.025em;
  line-height: 1.1; overflow-wrap: anywhere;
}
h2 { font-size: 1.05rem; font-weight: 650; letter-spacing: -0.005em; line-height: 1.35; }

.top {
  align-items: center; display: grid; gap: 2rem clamp(2rem, 5vw, 4.5rem);
  grid-template-columns: minmax(0, 1fr); padding-bottom: clamp(2rem, 5vw, 3.5rem);
}
.top .summary { font-size: 1.2rem; line-height: 1.45; margin-top: 1rem; text-wrap: pretty; }
.top .facts { color: var(--quiet); font-size: 0.9rem; margin-top: 0.9rem; }
.verdict { color: var(--quiet); font-size: 0.9rem; }
.top .verdict { margin-top: 1.75rem; }
.verdict strong { display: block; font-size: 1.2rem; font-weight: 650; line-height: 1.4; }
.ok .state, .verdict.ok strong { color: var(--good); }
.failed .state, .verdict.failed strong { color: var(--bad); }

section {
  border-top: 1px solid var(--line); display: grid; gap: 1.25rem 2.5rem;
  grid-template-columns: minmax(0, 1fr); padding: 1.75rem 0 clamp(2.25rem, 5vw, 3.5rem);
}
section > header p {
  color: var(--quiet); font-size: 0.85rem; line-height: 1.5; margin-top: 0.4rem;
}

.findings > li + li { border-top: 1px solid var(--line); margin-top: 1.75rem; padding-top: 1.5rem; }
.badge { font-family: var(--mono); font-size: 0.8rem; font-weight: 600; margin-right: 0.5rem; }
.error .badge { color: var(--bad); }
.warning .badge { color: var(--doubt); }
.findings .code { font-size: 0.95rem; }
.message { margin-top: 0.35rem; max-width: 46rem; }
.message code { color: var(--quiet); margin-right: 0.6em; }
.meaning { color: var(--quiet); font-size: 0.9rem; margin-top: 0.8rem; max-width: 46rem; }
.excerpt { margin-top: 0.8rem; }
.where { color: var(--quiet); font: 0.8rem/1.5 var(--mono); margin-bottom: 0.35rem; }
pre {
  background: var(--sunk); border-radius: 4px; font-size: 0.82rem; line-height: 1.7;
  overflow-x: auto; padding: 0.7rem 0; tab-size: 4;
}
pre code { display: inline-block; font-size: inherit; min-width: 100%; }
.line { display: block; padding: 0 1rem 0 0.8rem; white-space: pre; }
.line i {
  color: var(--quiet); font-style: normal; margin-right: 1.2rem; opacity: 0.75;
  user-select: none;
}
.line.here { background: var(--bad-wash); }
.warning .line.here { background: color-mix(in srgb, var(--doubt) 13%, transparent); }
mark {
  background: none; color: inherit; font-weight: 700;
  text-decoration: underline wavy var(--bad) 1px; text-underline-offset: 0.3em;
}
.warning mark { text-decoration-color: var(--doubt); }

.families > * { border-bottom: 1px solid var(--line); }
.families > :last-child { border-bottom: 0; }
.families > :first-child > .row { padding-top: 0; }
.row {
  align-items: baseline; display: grid; gap: 0 1rem; padding: 0.6rem 0;
  grid-template-columns: 3.5rem minmax(0, 1fr) auto;
}
summary { cursor: pointer; list-style: none; }
summary::-webkit-details-marker { display: none; }
summary:hover b { text-decoration: underline; text-underline-offset: 0.2em; }
.row b { font-weight: 600; }
.row .figures { color: var(--quiet); font-size: 0.92rem; grid-column: 2 / 4; grid-row: 2; }
.failed .row .figures { color: var(--ink); }
.state { font-size: 0.85rem; font-weight: 600; }
.skipped { color: var(--quiet); }
.skipped .state { font-weight: 400; }
table {
  border-collapse: collapse; font-size: 0.85rem; margin: 0.2rem 0 1.1rem; table-layout: fixed;
  width: 100%;
}
th { color: var(--quiet); font-weight: 400; }
th, td { padding: 0.22rem 0 0.22rem 1rem; text-align: right; vertical-align: baseline; }
th:first-child, td:first-child { padding-left: 0; text-align: left; width: 50%; }
th:last-child { width: 4.5rem; }
td:last-child { color: var(--quiet); font: 0.78rem var(--mono); }
tr.failed td { color: var(--bad); }

.strip, .failures, .cameras {
  display: grid; gap: 1.75rem 1.25rem;
  grid-template-columns: repeat(auto-fill, minmax(min(15rem, 100%), 1fr));
}
.caption { font-size: 0.88rem; line-height: 1.45; margin-top: 0.6rem; }
.stage { display: flex; padding: 0.1rem 0; }
.number { color: var(--quiet); flex: none; font-weight: 600; min-width: 1.5rem; }
.solved { color: var(--good); font-weight: 600; }
.strip p, .strip time { padding-left: 1.5rem; }
.caption time { font-size: 0.8rem; }
.failures .number { min-width: 0; padding-right: 0.5rem; }
.which b { margin-right: 0.6rem; }
.which span, .quiet { color: var(--quiet); }
.orders b { font-weight: 600; }
figcaption { color: var(--quiet); font-size: 0.88rem; margin-top: 0.5rem; }

.charts { display: grid; gap: 2.5rem 3rem; grid-template-columns: minmax(0, 1fr); }
.chart figcaption { color: var(--ink); font-weight: 600; margin: 0 0 0.6rem; }
.ways { font-size: 0.88rem; }
.ways li {
  align-items: center; display: grid; gap: 0 0.9rem;
  grid-template-columns: minmax(0, 9.5rem) minmax(0, 1fr) 3.2rem;
}
.ways .name { line-height: 1.25; overflow-wrap: anywhere; padding: 0.25rem 0; }
.ways .name small { display: block; font-size: 0.78rem; font-weight: 400; }
.ways .mean { text-align: right; }
.ways .plot { align-self: stretch; min-height: 1.9rem; position: relative; }
.ways svg { height: 100%; inset: 0; overflow: visible; position: absolute; width: 100%; }
.ways line { stroke: var(--line); stroke-width: 1; }
.ways .zero { stroke: var(--quiet); }
.ways .goal { stroke: var(--good); stroke-dasharray: 3 3; }
.ways .spread { stroke: var(--quiet); }
.ways .dot { fill: var(--quiet); fill-opacity: 0.35; }
.ways .mark { stroke: var(--ink); stroke-width: 3; }
.ways .expert { color: var(--good); font-weight: 600; }
.ways .expert .mark { stroke: var(--good); }
.ways .expert .dot { fill: var(--good); }
.ways .rival { color: var(--bad); font-weight: 600; }
.ways .rival .mark, .ways .rival .spread { stroke: var(--bad); }
.ways .rival .dot { fill: var(--bad); }
.ways .scale .plot { min-height: 1.4rem; }
.ways text { fill: var(--quiet); font-size: 0.75rem; text-anchor: middle; }

.measures {
  display: grid; gap: 0.9rem 2rem; grid-template-columns: repeat(auto-fill, minmax(10rem, 1fr));
}
.measures dt { color: var(--quiet); font-size: 0.85rem; }
.measures dd { font-size: 1.05rem; }

.index {
  display: grid; gap: 2.5rem 2rem;
  grid-template-columns: repeat(auto-fill, minmax(min(18rem, 100%), 1fr)); margin-top: 2.5rem;
}
.index a { color: inherit; display: block; text-decoration: none; }
.index a:hover h2 { text-decoration: underline; text-underline-offset: 0.2em; }
.index img { margin-bottom: 0.8rem; }
.index p { font-size: 0.92rem; margin-top: 0.35rem; }
.index .verdict strong { display: inline; font-size: inherit; margin-right: 0.5rem; }

footer {
  border-top: 1px solid var(--line); color: var(--quiet); font-size: 0.8rem; padding-top: 1rem;
}
main:has(> .index) { padding-bottom: clamp(2.25rem, 5vw, 3.5rem); }

@media (min-width: 52rem) {
  .top:has(> figure) { grid-template-columns: minmax(0, 5fr) minmax(0, 6fr); }
  section { grid-template-columns: 11rem minmax(0, 1fr); }
  .row { grid-template-columns: 3.5rem 9.5rem minmax(0, 1fr) auto; }
  .row .figures { grid-column: auto; grid-row: auto; }
  table { margin-left: 4.5rem; width: calc(100% - 4.5rem); }
}
@media (min-width: 68rem) {
  .charts { grid-template-columns: repeat(2, minmax(0, 1fr)); }
}
@media (max-width: 30rem) {
  .ways li { grid-template-columns: minmax(0, 1fr) 3.2rem; }
  .ways .plot { grid-column: 1 / 3; grid-row: 2; min-height: 1.5rem; }
  .ways .scale span:not(.plot) { display: none; }
  th:last-child, td:last-child { display: none; }
}
"""
