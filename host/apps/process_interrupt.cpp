#include "apps/process_interrupt.h"

#include <pthread.h>

#include <csignal>
#include <thread>

#include "io/whole_file.h"

namespace lamella::apps {

void abandon_outputs_on_interrupt() {
  sigset_t awaited;
  sigemptyset(&awaited);
  for (int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    sigaction(number, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&awaited, number);  // nohup stays nohup
  }
  pthread_sigmask(SIG_BLOCK, &awaited, nullptr);  // threads to come inherit it
  std::thread([awaited] {
    int number = 0;
    sigwait(&awaited, &number);
    abandon_outputs();
    std::signal(number, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &awaited, nullptr);
    raise(number);
  }).detach();
}

}  // namespace lamella::apps
