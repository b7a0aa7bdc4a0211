#pragma once

namespace mss {

/// How the page looks: one column with the contents above it on narrow screens, beside it on wide ones.
inline constexpr const char* page_style = R"(
:root { --text: #1f2328; --quiet: #515961; --link: #0a58b0; --line: #d5d9de; --soft: #f3f5f7; --bad: #a50f15; }
* { box-sizing: border-box; }
html { scroll-padding-top: 1rem; -webkit-text-size-adjust: 100%; }
body { margin: 0; color: var(--text); background: #fff; font: 16px/1.5 "DejaVu Sans", Verdana, sans-serif; overflow-wrap: anywhere; }
a { color: var(--link); }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 1.5rem 0 0.5rem; }
h2 { font-size: 1.35rem; margin: 0 0 0.25rem; }
h3 { font-size: 1.05rem; margin: 0 0 0.3rem; }
h2 a { color: inherit; text-decoration: none; }
p { margin: 0.5rem 0; max-width: 75ch; }
svg { display: block; width: 100%; height: auto; background: #fff; }
code, pre { font-family: "DejaVu Sans Mono", Menlo, monospace; font-size: 0.85rem; }
pre { margin: 0.5rem 0; padding: 0.7rem; overflow-x: auto; overflow-wrap: normal; background: var(--soft); border-radius: 4px; }
pre.command { user-select: all; }
table { border-collapse: collapse; font-size: 0.9rem; }
th, td { padding: 0.3rem 1rem 0.3rem 0; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
summary { cursor: pointer; padding: 0.6rem 0; color: var(--link); }
.page { max-width: 90rem; margin: 0 auto; padding: 0 1rem 3rem; }
.scrolls { overflow-x: auto; }
figure .scrolls svg { min-width: 46rem; }
.hint { display: none; color: var(--quiet); font-size: 0.9rem; }
.findings { margin: 0.5rem 0; padding-left: 1.2rem; max-width: 85ch; }
.findings li { margin: 0.35rem 0; }
.quiet { color: var(--quiet); font-size: 0.9rem; }
.bad { color: var(--bad); font-weight: bold; }
.facts { display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: 0.1rem 1rem; margin: 1rem 0; font-size: 0.9rem; }
.facts dt { color: var(--quiet); }
.facts dd { margin: 0; }

nav ul { margin: 0; padding: 0; list-style: none; }
nav ul ul { margin-left: 0.8rem; font-size: 0.85rem; }
nav a { display: block; padding: 0.35rem 0; text-decoration: none; }
nav li details summary { padding: 0 0 0.2rem; font-size: 0.8rem; color: var(--quiet); }
nav a:hover { text-decoration: underline; }
nav.beside { display: none; }

.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 17rem), 1fr)); gap: 1rem; margin: 1rem 0; padding: 0; list-style: none; }
.cards li { border: 1px solid var(--line); border-radius: 6px; overflow: hidden; }
.cards a { display: block; font-weight: bold; }
.cards span { display: block; padding: 0.6rem 0.8rem 0; }
.cards svg { aspect-ratio: 4 / 3; border-bottom: 1px solid var(--line); }
.cards p { margin: 0.2rem 0.8rem 0.6rem; font-size: 0.9rem; }

main section { border-top: 2px solid var(--line); margin-top: 2.5rem; padding-top: 1.5rem; }
figure { margin: 1.5rem 0; }
figcaption p { margin: 0.2rem 0; }
.links { display: flex; flex-wrap: wrap; gap: 0.5rem; margin: 0.4rem 0; padding: 0; list-style: none; font-size: 0.9rem; }
.links a { display: inline-block; padding: 0.35rem 0.7rem; border: 1px solid var(--line); border-radius: 4px; text-decoration: none; }

@media (max-width: 40rem) {
  .cards { grid-template-columns: minmax(0, 1fr); gap: 0.5rem; }
  .cards li { display: grid; grid-template-columns: 7.5rem minmax(0, 1fr); }
  .cards li a { grid-row: 1 / 3; }
  .cards svg { border: 0; }
  .cards span { padding: 0.2rem 0.4rem; font-size: 0.9rem; }
  .cards p { margin: 0.3rem 0.5rem; }
}
@media (max-width: 52rem) {
  .hint { display: block; }
}
@media (min-width: 64rem) {
  .page { display: grid; grid-template-columns: 17rem minmax(0, 1fr); gap: 2.5rem; }
  nav.beside { display: block; position: sticky; top: 0; max-height: 100vh; overflow-y: auto; padding: 1.5rem 0; font-size: 0.9rem; }
  nav.beside a { padding: 0.12rem 0; }
  nav.above { display: none; }
}
@media print {
  .page { display: block; max-width: none; }
  nav, .hint { display: none !important; }
  figure .scrolls svg { min-width: 0; }
  figure, .cards li { break-inside: avoid; }
}
)";

}  // namespace mss
