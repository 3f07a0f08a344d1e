// The pages that the search of a built site finds for some words, best first: node site_search.js SITE WORDS ...
// It runs the worker of the site, with a stand-in for what a browser gives it.
const fs = require("fs"), path = require("path"), vm = require("vm");
const [site, ...queries] = process.argv.slice(2);
const workers = path.join(site, "assets/javascripts/workers");
const worker = fs.readdirSync(workers).find(name => name.endsWith(".js"));
const index = JSON.parse(fs.readFileSync(path.join(site, "search/search_index.json"), "utf8"));
const browser = { addEventListener: (_, answer) => { browser.answer = answer; }, postMessage: message => { browser.said = message; }, importScripts() {}, URL, setTimeout };
browser.self = browser;
vm.runInContext(fs.readFileSync(path.join(workers, worker), "utf8"), vm.createContext(browser));
const name = hit => path.basename(hit.location.split("#")[0], ".html");
(async () => {
  await browser.answer({ data: { type: 0, data: { config: index.config, docs: index.docs, options: { suggest: false } } } });
  for (const query of queries) {
    await browser.answer({ data: { type: 2, data: query } });
    console.log([query, ...browser.said.data.items.slice(0, 3).map(hits => name(hits[0]))].join("\t"));
  }
})();
