// Messages to the server: a newer request overtakes older ones, and stale answers are not shown.

const MAX_PINS = 4;
const MAX_NAME = 40;
const page = Math.random().toString(36).slice(2);
const talk = { number: 0, busy: false, dirty: false, aborter: null, rest: 0 };

// Address of a file or an answer; in a frame of a notebook it carries the token, since frames of another site have no cookies.
const addressOf = (path) => path + document.documentElement.dataset.query;

const post = (path, content, signal) => fetch(addressOf(path), {
  method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(content), signal, credentials: "same-origin",
});

// The lines of a response as they come, each read as JSON.
async function* linesOf(response) {
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (;;) {
    const { value, done } = await reader.read();
    const lines = (rest + (value ?? "")).split("\n");
    rest = lines.pop();
    for (const line of lines) if (line) yield JSON.parse(line);
    if (done) { if (rest) yield JSON.parse(rest); return; }
  }
}

const byHand = () => ({ values: studio.values, pins: studio.pins, scenario: studio.scenario, channel: studio.channel });

// Ask for the answer to the present setting; while the first line of one is under way, the next request waits for it.
function request() {
  delete document.documentElement.dataset.rest;
  if (talk.busy) { talk.dirty = true; return; }
  send();
}

async function send() {
  talk.number += 1;
  const mine = talk.number;
  talk.aborter?.abort();
  talk.aborter = new AbortController();
  Object.assign(talk, { busy: true, dirty: false });
  const begin = performance.now();
  try {
    const response = await post("/answer", { number: mine, page, ...byHand() }, talk.aborter.signal);
    for await (const message of linesOf(response)) {
      if (mine !== talk.number) return;
      if (message.progress !== undefined) say(message.progress);
      else if (message.error !== undefined) { complain(message.error); release(mine); }
      else { show(message, begin); release(mine); }
    }
  } catch (error) {
    if (error.name !== "AbortError") complain("The studio has ended, or cannot be reached. Start it again with `tuner studio` and open the address that it prints.");
  } finally {
    release(mine);
  }
}

function release(mine) {
  if (mine !== talk.number || !talk.busy) return;
  talk.busy = false;
  if (talk.dirty) send();
}

function say(text) {
  byId("progress").textContent = text;
}

function complain(text) {
  byId("notice").textContent = text;
  byId("notice").hidden = !text;
  byId("progress").textContent = "";
}
