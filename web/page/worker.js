// The worker: dpn in WebAssembly, a log in its memory. The page starts a new one for every log and ends it to cancel.
"use strict";
const PART = 4 << 20;
let session = null;
let wasm = null;

/** A log's bytes as they are asked for; says how far it is. */
class LogSource {
  constructor({ file, url, size }) {
    Object.assign(this, { file, url, size: file ? file.size : size, at: 0 });
  }
  read() {
    const to = Math.min(this.at + PART, this.size);
    if (to <= this.at) return new Uint8Array();
    const bytes = this.file ? new FileReaderSync().readAsArrayBuffer(this.file.slice(this.at, to)) : this.fetched(this.at, to);
    this.at += bytes.byteLength;
    postMessage({ kind: "read", done: this.at, total: this.size });
    return new Uint8Array(bytes);
  }
  fetched(from, to) {
    const request = new XMLHttpRequest();
    request.open("GET", this.url, false);
    request.responseType = "arraybuffer";
    request.setRequestHeader("Range", `bytes=${from}-${to - 1}`);
    request.send();
    if (request.status !== 206) throw new Error(`the server answers ${request.status}`);
    return request.response;
  }
}

/** Called from WebAssembly: the share of the noise that is made. */
globalThis.noiseProgress = (share) => postMessage({ kind: "made", share });

/** Runs `work`; what it throws becomes a sentence, or ends the whole where the memory is in no known state. */
function told(kind, work) {
  try {
    postMessage({ kind: "begin", what: kind });
    postMessage({ kind, ...work() });
    return true;
  } catch (error) {
    if (error instanceof WebAssembly.RuntimeError || error instanceof RangeError) {
      const text = "This log does not fit into a page's memory, or its reader failed.\nOpen it by `dpn page LOG` or look at it with `dpn check LOG`.";
      postMessage({ kind: "failure", text });
      close();
      throw error;
    }
    postMessage({ kind: kind === "check" ? "failure" : `${kind}-none`, text: error.message });
    return false;
  }
}

const lines = (text) => text.trimEnd().split("\n");

function answers() {
  told("noise", () => {
    const [json, picture] = lines(session.noise());
    return { json, picture };
  });
  told("allan", () => {
    const [json, more] = lines(session.allan());
    return { json, more };
  });
  // It only grows, so that this is the most it was.
  postMessage({ kind: "done", memory: wasm.memory.buffer.byteLength });
}

onmessage = ({ data }) => {
  if (data.module) wasm = wasm_bindgen.initSync({ module: data.module });
  if (data.convert) {
    try {
      postMessage({ kind: "converted", json: wasm_bindgen.convert(...data.convert) });
    } catch (error) {
      postMessage({ kind: "converted", text: error.message });
    }
    return;
  }
  if (data.source) {
    const read = told("check", () => {
      session = wasm_bindgen.Session.open(new LogSource(data.source), data.name, data.topic || "");
      return { json: session.check().trimEnd(), told: session.told() };
    });
    if (!read) return;
  }
  if (data.config) {
    try {
      session.configure(data.config.name, new Uint8Array(data.config.bytes));
    } catch (error) {
      postMessage({ kind: "config-none", text: error.message });
    }
  }
  if (session) answers();
};
