// Lets the search of the site work in pages that are opened as files, for which browsers start no workers: the script of the worker runs in a
// hidden frame instead. It is named as the theme knows such a stand-in.
if (location.protocol === "file:") {
  window.IFrameWorker = class extends EventTarget {
    constructor(url) {
      super()
      const frame = document.createElement("iframe")
      frame.hidden = true
      document.body.appendChild(frame)
      const inner = frame.contentWindow
      const load = (address) => new Promise((done, failed) => {
        const script = inner.document.createElement("script")
        Object.assign(script, { src: address, onload: done, onerror: failed })
        inner.document.body.appendChild(script)
      })
      inner.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }))
      inner.importScripts = (...addresses) => addresses.reduce((before, address) => before.then(() => load(address)), Promise.resolve())
      this.ready = load(new URL(url, location.href).href)
      this.inner = inner
    }
    postMessage(data) {
      this.ready.then(() => this.inner.dispatchEvent(new this.inner.MessageEvent("message", { data })))
    }
    terminate() {
      this.inner.frameElement.remove()
    }
  }
  window.Worker = window.IFrameWorker
}
