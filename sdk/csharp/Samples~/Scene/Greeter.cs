using System;
using System.Linq;
using System.Threading.Tasks;
using OpenRoIS.Components;
using OpenRoIS.Media;
using OpenRoIS.Unity;
using Unity.WebRTC;
using UnityEngine;

namespace OpenRoIS.Samples
{
    /// <summary>
    /// Lets a body that is free greet, and shows what its camera sees. Put it on an object with an <see cref="OpenRoISClient"/>,
    /// drag a renderer to <c>Screen</c>, and call <see cref="Greet"/> from a button.
    /// </summary>
    [RequireComponent(typeof(OpenRoISClient))]
    public sealed class Greeter : MonoBehaviour
    {
        [Tooltip("Shows the pictures of the body")]
        public Renderer Screen;

        [Tooltip("What the body says")]
        public string Words = "Hello! I am glad to see you.";

        private Client _client;
        private MediaSession _media;
        private Body _body;
        private bool _isBusy;

        /// <summary>To be called from a button.</summary>
        public async void Greet()
        {
            if (_isBusy || _body == null)
            {
                return;
            }
            _isBusy = true;
            try
            {
                await GreetAsync(_body);
            }
            catch (RoISException error)
            {
                // Another application has taken the body, or it has failed.
                Debug.LogWarning(error.Message);
            }
            catch (ConnectionLostException error)
            {
                Debug.LogWarning(error.Message);
            }
            _isBusy = false;
        }

        private async void Start()
        {
            try
            {
                _client = await GetComponent<OpenRoISClient>().ConnectedAsync();
            }
            catch (OperationCanceledException)
            {
                return;
            }
            // Unity's WebRTC package decodes pictures in this coroutine.
            StartCoroutine(WebRTC.Update());
            _media = new MediaSession(_client, request => new WebRtcPeer(request, this, Show));
            _client.BodyLost += Lost;
            _client.ConnectionChanged += Changed;
            Reserve();
        }

        private void OnDestroy()
        {
            _media?.Dispose();
            _body?.Dispose();
        }

        private async void Reserve()
        {
            try
            {
                _body = await _client.BodyAsync(new BodyRequest(SpeechSynthesis.Type)
                {
                    Optional = new ComponentType[] { Reaction.Type, VideoStreaming.Type },
                    Wait = TimeSpan.FromDays(1)
                });
            }
            catch (ConnectionLostException)
            {
                // The scene has ended, or the gateway does not let this application in any more: the client says why.
                return;
            }
            Watch();
        }

        private async void Watch()
        {
            VideoStreaming video = _body?.Find(VideoStreaming.Type);
            try
            {
                await (video?.ConnectStreamAsync(encoding: new { codecs = new[] { "video/H264", "video/VP8" } })
                    ?? Task.FromResult(""));
            }
            catch (Exception error)
            {
                Debug.LogWarning("no pictures: " + error.Message);
            }
        }

        private async Task GreetAsync(Body body)
        {
            SpeechSynthesis speech = body.Part(SpeechSynthesis.Type);
            Reaction reaction = body.Find(Reaction.Type);
            await speech.SetAsync(speechText: Words);
            if (reaction == null)
            {
                await speech.StartAsync();
                return;
            }
            await reaction.SetAsync(reactionRef: (await reaction.AvailableReactionsAsync()).First());
            await _client.RunAsync(new Concurrent(speech.StartStep(), reaction.StartStep()));
        }

        private void Lost(BodyLoss loss)
        {
            Debug.LogWarning(loss.EngineId + " is lost: " + loss.Error.Message);
            _body?.Dispose();
            _body = null;
            Reserve();
        }

        private void Changed(ConnectionChange change)
        {
            // Streams end with their connection; the body is kept.
            if (change.State == ConnectionState.Connected)
            {
                Watch();
            }
        }

        private void Show(Texture picture)
        {
            Screen.material.mainTexture = picture;
        }
    }
}
