/// Links with every object of haptic_owner and with nothing else of the server (owner_links.sh).
int main() {}
