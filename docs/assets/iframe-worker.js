/* Search also works where the site is opened as files: browsers start no worker from a file, so its script runs in a hidden frame. */
class FrameWorker extends EventTarget {
  constructor(url) {
    super();
    this.waiting = [];
    this.frame = document.createElement("iframe");
    this.frame.hidden = true;
    document.body.append(this.frame);
    const inside = this.frame.contentWindow;
    inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
    const script = inside.document.createElement("script");
    script.src = url;
    script.addEventListener("load", () => {
      this.loaded = true;
      this.waiting.splice(0).forEach((data) => this.postMessage(data));
    });
    inside.document.body.append(script);
  }

  postMessage(data) {
    if (!this.loaded) {
      this.waiting.push(data);
      return;
    }
    const { contentWindow } = this.frame;
    contentWindow.dispatchEvent(new contentWindow.MessageEvent("message", { data }));
  }

  terminate() {
    this.frame.remove();
  }
}

if (location.protocol === "file:") {
  window.Worker = FrameWorker;
}
